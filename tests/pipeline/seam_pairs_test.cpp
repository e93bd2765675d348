// SPDX-License-Identifier: MIT
#include "pipeline/seam_pairs.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

std::vector<SeamPair> paired_seams(const Surface& original, const Surface& level) {
  return paired_seams(original, level, paired(original, level));
}

}  // namespace

TEST_SUITE("seam_pairs") {
  TEST_CASE("a seam is paired with the seam, from both sides for both planes, by its length squared") {
    const Surface original = bending_tube(24, 30, 3).surface, level = bending_tube(12, 10, 3).surface;
    const auto pairs = paired_seams(original, level);
    const Neighbourhood a(original), b(level);
    double sum = 0;
    for (const SeamPair& pair : pairs) {
      const Vec3 x = a.at(original.position, pair.original), y = b.at(level.position, pair.level);
      CHECK((x - y).norm() < 1e-12);  // the seam is a straight line, and another over each cap to its middle
      CHECK(std::abs(x.z()) < 1e-12);
      CHECK(x.x() > 0);
      for (const int v : {pair.edge.kept, pair.edge.removed}) {
        const auto face = triangle_vertices(original, pair.original.face);
        CHECK(std::find(face.begin(), face.end(), v) != face.end());
      }
      sum += pair.area;
    }
    CHECK(pairs.size() == 2 * 2 * (10 + 2 + 30 + 2));
    CHECK(sum == doctest::Approx(2 * 2 * (10 * 0.3 * 0.3 + 2) / area(level)));
  }

  TEST_CASE("a seam that only one has is paired with nothing, and a border is no seam") {
    const Surface tube = bending_tube(24, 30, 3).surface, level = bending_tube(12, 10, 3).surface;
    Surface whole = tube;
    whole.attributes.col(whole.layout.uv_at(0)).setZero();
    CHECK(paired_seams(whole, level).empty());
    CHECK(paired_seams(tube, whole).empty());
    CHECK(paired_seams(sheet(12), sheet(4)).empty());
  }

  TEST_CASE("a seam at the other side of a character is not paired") {
    const Surface tube = bending_tube(24, 30, 3).surface;
    Surface level = bending_tube(12, 10, 3).surface;
    for (Vec3& x : level.position) x = Vec3(-x.x(), x.y(), -x.z());
    const auto pairs = paired_seams(tube, level);
    CHECK(pairs.size() <= 2 * 2 * (2 + 2));
    for (const SeamPair& pair : pairs) {
      const Vec3 x = Neighbourhood(level).at(level.position, pair.level);
      CHECK(std::hypot(x.x(), x.z()) < 1);  // over the caps, whose seams meet in the middle
    }
  }
}
