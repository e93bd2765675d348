// SPDX-License-Identifier: MIT
#include <cstring>
#include <random>

#include "tests/fuzz/checksums.h"
#include "tests/fuzz/corpus.h"
#include "tests/fuzz/readers.h"  // what libFuzzer runs
#include "tests/packed_tube.h"

namespace skinlod {
namespace {

std::vector<std::uint8_t> small_file(bool compress) {
  const std::vector<Level> levels = {as_level(decorated_tube(4, 4).surface, 4, 0),
                                     as_level(decorated_tube(3, 2).surface, 2, 1)};
  const std::vector<std::byte> bytes = pack(decorated_tube(4, 4), levels, {.compress = compress});
  std::vector<std::uint8_t> copy(bytes.size());
  std::memcpy(copy.data(), bytes.data(), bytes.size());
  return copy;
}

}  // namespace

TEST_SUITE("slod_hostile") {
  TEST_CASE("the fuzzer's stored inputs are read or refused") {
    int read = 0, refused = 0;
    for (auto [name, bytes] : fuzz::corpus("slod_reader")) {
      const auto& input = name;  // clang 14 captures no structured binding
      CAPTURE(input);
      bool is_read = false;
      CHECK_NOTHROW(is_read = fuzz::read_as_slod(bytes));
      fuzz::repair_checksums(bytes);
      CHECK_NOTHROW(is_read |= fuzz::read_as_slod(bytes));
      ++(is_read ? read : refused);
    }
    CHECK(read > 0);
    CHECK(refused > 0);
  }

  TEST_CASE("every truncated file is refused") {
    const std::vector<std::uint8_t> whole = small_file(true);
    REQUIRE(fuzz::read_as_slod(whole));
    for (size_t size = 0; size < whole.size(); ++size) {
      CAPTURE(size);
      std::vector<std::uint8_t> prefix(whole.begin(), whole.begin() + std::ptrdiff_t(size));
      CHECK_FALSE(fuzz::read_as_slod(prefix));
      fuzz::repair_checksums(prefix);
      CHECK_FALSE(fuzz::read_as_slod(prefix));
    }
  }

  TEST_CASE("random bit flips behind true checksums are read or refused") {
    for (const bool compress : {false, true}) {
      const std::vector<std::uint8_t> whole = small_file(compress);
      int read = 0, refused = 0;
      for (std::uint32_t seed = 0; seed < 5000; ++seed) {
        CAPTURE(seed);
        std::mt19937 random(seed);
        std::vector<std::uint8_t> flipped = whole;
        for (auto flips = 1 + random() % 4; flips > 0; --flips) {
          flipped[random() % flipped.size()] ^= std::uint8_t(1u << random() % 8);
        }
        fuzz::repair_checksums(flipped);
        bool is_read = false;
        CHECK_NOTHROW(is_read = fuzz::read_as_slod(flipped));
        ++(is_read ? read : refused);
      }
      CHECK(read > 100);
      CHECK(refused > 100);
    }
  }
}

}  // namespace skinlod
