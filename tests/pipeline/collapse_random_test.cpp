// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <random>

#include "tests/fuzz/collapse.cpp"  // the function that libFuzzer runs
#include "tests/fuzz/corpus.h"

namespace skinlod {
namespace {

using Bytes = std::vector<std::uint8_t>;

// Two rows of the first layer's 8 x 4 places after the other, as triangles or quads: a surface in one piece.
Bytes grid(std::uint8_t choice) {
  Bytes bytes = {choice};
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 7; ++x) {
      const auto at = [&](int i, int j) { return std::uint8_t(2 * (8 * (y + j) + x + i)); };  // a wedge
      const Bytes quad = {at(0, 0), at(1, 0), at(1, 1), at(0, 1)};
      const Bytes triangles = {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]};
      const Bytes& corners = choice & 1 ? quad : triangles;
      bytes.insert(bytes.end(), corners.begin(), corners.end());
    }
  }
  return bytes;
}

}  // namespace

TEST_SUITE("collapse_random") {
  TEST_CASE("the fuzzer's stored index buffers collapse to a sound mesh") {
    size_t collapses = 0;
    for (const auto& [name, bytes] : fuzz::corpus("collapse")) {
      const auto& input = name;  // clang 14 captures no structured binding
      CAPTURE(input);
      CHECK_NOTHROW(collapses += fuzz::collapse_faces_of(bytes));
    }
    CHECK(collapses > 0);
  }

  TEST_CASE("any index buffer collapses to a sound mesh") {
    size_t collapses = 0;
    for (std::uint32_t seed = 0; seed < 500; ++seed) {
      CAPTURE(seed);
      std::mt19937 random(seed);
      Bytes bytes(2 + random() % 200);
      for (std::uint8_t& byte : bytes) byte = std::uint8_t(random());
      CHECK_NOTHROW(collapses += fuzz::collapse_faces_of(bytes));
    }
    CHECK(collapses > 500);
  }

  TEST_CASE("a grid with any corners changed collapses to a sound mesh") {
    size_t collapses = 0;
    for (std::uint32_t seed = 0; seed < 500; ++seed) {
      CAPTURE(seed);
      std::mt19937 random(seed);
      Bytes bytes = grid(std::uint8_t(random()));
      for (auto changes = random() % 12; changes > 0; --changes) {
        bytes[1 + random() % (bytes.size() - 1)] = std::uint8_t(random());
      }
      if (random() % 4 == 0) bytes.resize(1 + random() % bytes.size());
      CHECK_NOTHROW(collapses += fuzz::collapse_faces_of(bytes));
    }
    CHECK(collapses > 5000);
  }
}

}  // namespace skinlod
