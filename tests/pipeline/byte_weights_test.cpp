// SPDX-License-Identifier: MIT
#include "pipeline/byte_weights.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/chain.h"
#include "pipeline/repair.h"
#include "tests/random.h"
#include "tests/shapes.h"

using namespace skinlod;

namespace {

bool in_bytes(const Influences& influences) {
  return std::ranges::all_of(influences, [](const Influence& i) {
    const double parts = i.weight * 255;
    return parts > 0.5 && std::abs(parts - std::round(parts)) < 1e-9;
  });
}

}  // namespace

TEST_SUITE("byte_weights") {
  TEST_CASE("rounded weights sum to 1, are at most one 255th off, and stay when they are rounded again") {
    std::mt19937 random(3);
    for (int trial = 0; trial < 500; ++trial) {
      Influences influences;
      double sum = 0;
      for (int joint = 0; joint < 1 + trial % 8; ++joint) {
        influences.push_back({joint, uniform(random, 0.001, 1)});
        sum += influences.back().weight;
      }
      for (Influence& i : influences) i.weight /= sum;
      const Influences once = rounded(influences);
      CHECK(in_bytes(once));
      CHECK(rounded(once) == once);
      int bytes = 0;
      for (const ByteInfluence& i : round_weights(once)) bytes += i.weight;
      CHECK(bytes == 255);
      for (const Influence& i : influences) {
        const auto same = std::ranges::find(once, i.joint, &Influence::joint);
        CHECK(std::abs(i.weight - (same == once.end() ? 0 : same->weight)) < 1 / 255.0);
      }
    }
  }

  TEST_CASE(
      "the weights of fitted levels are 255ths, but where they are locked, and none are where not asked") {
    Character c = part_of(bending_tube(12, 24, 4), [](const Vec3& middle) { return middle.y() < 2; });
    repair(c);
    for (const bool bytes : {true, false}) {
      CAPTURE(bytes);
      const Chain chain = build_chain(c, few_poses(c),
                                      {.targets = {{.ratio = 0.4}},
                                       .borders = Borders::Locked,
                                       .byte_weights = bytes,
                                       .measured = false});
      const Surface& level = chain.levels[1].surface;
      const std::vector<char> locked = locked_vertices(level, Borders::Locked);
      int held = 0, whole = 0, other = 0;
      for (size_t v = 0; v < level.influences.size(); ++v) {
        const Influences& its = level.influences[v];
        if (locked[v]) {
          ++held;
          CHECK(std::ranges::find(c.surface.influences, its) != c.surface.influences.end());
        } else {
          ++(in_bytes(its) ? whole : other);
          CHECK((rounded(its) == its) == in_bytes(its));
        }
      }
      CHECK(held > 0);
      CHECK(whole > 0);
      CHECK((other == 0) == bytes);
    }
  }
}
