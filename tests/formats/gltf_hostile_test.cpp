// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <random>

#include "formats/gltf.h"
#include "pipeline/error.h"
#include "tests/formats/gltf_sample.h"
#include "tests/formats/scratch.h"

namespace skinlod {
namespace {

// True where the bytes are read as a character whose parts fit together, false where they are refused.
bool survives(const Scratch& folder, const std::vector<unsigned char>& bytes) {
  try {
    const Imported imported = import_gltf(folder.file("hostile.glb", text(bytes)));
    const Surface& s = imported.character.surface;
    REQUIRE(s.influences.size() == s.position.size());
    REQUIRE(s.wedges.size() == s.position.size());
    REQUIRE(size_t(s.attributes.rows()) == s.wedges.size());
    for (const int wedge : s.corners) REQUIRE(wedge < int(s.wedges.size()));
    return true;
  } catch (const Error& e) {
    REQUIRE((e.fault == Fault::Input || e.fault == Fault::Access));
    return false;
  }
}

}  // namespace

TEST_SUITE("gltf_hostile") {
  TEST_CASE("every truncated file is refused") {
    const Scratch folder;
    const std::vector<unsigned char> whole = sample_file().glb();
    REQUIRE(survives(folder, whole));
    for (size_t size = 0; size < whole.size(); ++size) {
      CAPTURE(size);
      std::vector<unsigned char> prefix(whole.begin(), whole.begin() + std::ptrdiff_t(size));
      CHECK_FALSE(survives(folder, prefix));
      if (size < 12) continue;
      const auto length = std::uint32_t(size);  // a header that agrees with the file
      std::memcpy(&prefix[8], &length, sizeof length);
      CHECK_FALSE(survives(folder, prefix));
    }
  }

  TEST_CASE("random bit flips are read or refused") {
    const Scratch folder;
    const std::vector<unsigned char> whole = sample_file({.index_type = 5123}).glb();
    int read = 0, refused = 0;
    for (std::uint32_t seed = 0; seed < 5000; ++seed) {
      CAPTURE(seed);
      std::mt19937 random(seed);
      std::vector<unsigned char> flipped = whole;
      const std::uint32_t flips = 1 + random() % 4;
      for (std::uint32_t i = 0; i < flips; ++i)
        flipped[random() % flipped.size()] ^= (unsigned char)(1u << random() % 8);
      ++(survives(folder, flipped) ? read : refused);
    }
    CHECK(read > 100);
    CHECK(refused > 100);
  }
}

}  // namespace skinlod
