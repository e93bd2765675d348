// SPDX-License-Identifier: MIT
#include <array>
#include <random>

#include "tests/fuzz/corpus.h"
#include "tests/fuzz/slod.cpp"  // the function that libFuzzer runs
#include "tests/packed_tube.h"

namespace skinlod {
namespace {

// Changes one to four places: a bit, a byte, or a 32-bit word by a number that liars like.
void corrupt(std::vector<std::uint8_t>& bytes, size_t first, size_t last, std::mt19937& random) {
  constexpr std::array<std::uint32_t, 8> kLies = {0,          1,          0xff,       0xffff,
                                                  0x7fffffff, 0x80000000, 0xfffffff0, 0xffffffff};
  for (std::uint32_t changes = 1 + random() % 4; changes > 0; --changes) {
    const size_t at = first + random() % (last - first - 4);
    std::uint32_t word;
    std::memcpy(&word, &bytes[at], 4);
    switch (random() % 4) {
      case 0:
        word ^= 1u << random() % 32;
        break;
      case 1:
        word = (word & ~0xffu) | random() % 256;
        break;
      case 2:
        word = kLies[random() % kLies.size()];
        break;
      default:
        word += std::uint32_t(random() % 33) - 16;
    }
    std::memcpy(&bytes[at], &word, 4);
  }
}

std::vector<std::uint8_t> small_file(bool compress) {
  const std::array levels = {as_level(decorated_tube(4, 4).surface, 4, 0),
                             as_level(decorated_tube(3, 2).surface, 2, 1)};
  const auto bytes = pack(decorated_tube(4, 4), levels, {.compress = compress});
  std::vector<std::uint8_t> copy(bytes.size());
  std::memcpy(copy.data(), bytes.data(), bytes.size());
  return copy;
}

}  // namespace

TEST_SUITE("corruption") {
  TEST_CASE("the fuzzer's stored inputs end in a status") {
    std::array<int, SLOD_BAD_ARGUMENT + 1> seen{};
    for (auto [name, bytes] : fuzz::corpus("slod")) {
      const auto& input = name;  // clang 14 captures no structured binding
      CAPTURE(input);
      ++seen[size_t(fuzz::play(bytes, false))];
      fuzz::repair_checksums(bytes);
      ++seen[size_t(fuzz::play(bytes, true))];
    }
    for (const slod_status status : {SLOD_OK, SLOD_BAD_TABLE, SLOD_BAD_RECORD, SLOD_BAD_STREAM}) {
      CAPTURE(std::string(slod_status_text(status)));
      CHECK(seen[size_t(status)] > 0);
    }
  }

  TEST_CASE("100000 random corruptions end in a status") {
    constexpr int kRounds = 50000;  // of each of two files
    std::array<int, SLOD_BAD_ARGUMENT + 1> seen{};
    std::mt19937 random(7);
    for (const bool compress : {false, true}) {
      const auto good = small_file(compress);
      CHECK(fuzz::play(good, false) == SLOD_OK);
      slod_header header;
      std::memcpy(&header, good.data(), sizeof header);
      for (int round = 0; round < kRounds; ++round) {
        auto bytes = good;
        // Streams and head by turns; without regard to checksums, but for every sixteenth.
        const bool head = round % 2 == 0;
        corrupt(bytes, head ? 0 : header.head_bytes, head ? header.head_bytes : bytes.size(), random);
        if (round % 16 != 1) fuzz::repair_checksums(bytes);
        ++seen[size_t(fuzz::play(bytes, round % 4 >= 2))];
      }
    }
    // Each kind of lie was told, and the checksums did not hide it.
    CHECK(seen[SLOD_OK] > 1000);
    CHECK(seen[SLOD_BAD_CHECKSUM] > 1000);
    CHECK(seen[SLOD_BAD_TABLE] > 1000);
    CHECK(seen[SLOD_BAD_RECORD] > 1000);
    CHECK(seen[SLOD_BAD_STREAM] > 1000);
    CHECK(seen[SLOD_TRUNCATED] + seen[SLOD_NOT_SLOD] + seen[SLOD_OTHER_VERSION] > 10);
    CHECK(seen[SLOD_BUFFER_TOO_SMALL] == 0);
    CHECK(seen[SLOD_NO_CODEC] == 0);
  }

  TEST_CASE("every prefix of a file with true checksums ends in a status") {
    const auto good = small_file(true);
    for (size_t size = 0; size < good.size(); ++size) {
      const std::vector<std::uint8_t> prefix(good.begin(), good.begin() + std::ptrdiff_t(size));
      CAPTURE(size);
      CHECK(fuzz::play(prefix, false) == SLOD_TRUNCATED);
      LLVMFuzzerTestOneInput(prefix.data(), prefix.size());
    }
  }

  TEST_CASE("a count that lies cannot make the caller allocate without limit") {
    const auto good = small_file(true);
    slod_file file;
    REQUIRE(slod_open(good.data(), good.size(), &file) == SLOD_OK);
    for (std::uint32_t c = SLOD_SHARED_KINDS; c < file.chunk_count; ++c) {
      for (const std::uint32_t count : {0u, 0x10000000u, 0xfffffffcu}) {
        auto bytes = good;
        const size_t at = sizeof(slod_header) + c * sizeof(slod_chunk) + offsetof(slod_chunk, count);
        std::memcpy(&bytes[at], &count, sizeof count);
        fuzz::repair_checksums(bytes);
        CHECK(fuzz::play(bytes, true) == SLOD_BAD_TABLE);
      }
    }
  }
}

}  // namespace skinlod
