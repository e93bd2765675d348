// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <random>

#include "tests/formats/gltf_sample.h"
#include "tests/fuzz/readers.h"  // what libFuzzer runs

namespace skinlod {

TEST_SUITE("gltf_hostile") {
  TEST_CASE("every truncated file is refused") {
    const std::vector<unsigned char> whole = sample_file().glb();
    REQUIRE(fuzz::read_as_gltf(whole));
    for (size_t size = 0; size < whole.size(); ++size) {
      CAPTURE(size);
      std::vector<unsigned char> prefix(whole.begin(), whole.begin() + std::ptrdiff_t(size));
      CHECK_FALSE(fuzz::read_as_gltf(prefix));
      if (size < 12) continue;
      const auto length = std::uint32_t(size);  // a header that agrees with the file
      std::memcpy(&prefix[8], &length, sizeof length);
      CHECK_FALSE(fuzz::read_as_gltf(prefix));
    }
  }

  TEST_CASE("random bit flips are read or refused") {
    const std::vector<unsigned char> whole = sample_file({.index_type = 5123}).glb();
    int read = 0, refused = 0;
    for (std::uint32_t seed = 0; seed < 5000; ++seed) {
      CAPTURE(seed);
      std::mt19937 random(seed);
      std::vector<unsigned char> flipped = whole;
      const std::uint32_t flips = 1 + random() % 4;
      for (std::uint32_t i = 0; i < flips; ++i)
        flipped[random() % flipped.size()] ^= (unsigned char)(1u << random() % 8);
      bool is_read = false;
      CHECK_NOTHROW(is_read = fuzz::read_as_gltf(flipped));
      ++(is_read ? read : refused);
    }
    CHECK(read > 100);
    CHECK(refused > 100);
  }
}

}  // namespace skinlod
