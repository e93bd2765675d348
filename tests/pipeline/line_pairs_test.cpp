// SPDX-License-Identifier: MIT
#include "pipeline/line_pairs.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

std::vector<LinePair> paired_lines(const Surface& original, const Surface& level) {
  return paired_lines(original, level, paired(original, level), {.border = 2, .seam = 0.5});
}

}  // namespace

TEST_SUITE("line_pairs") {
  TEST_CASE("a seam is paired with the seam, from both sides and in both planes, by its length squared") {
    const Surface original = bending_tube(24, 30, 3).surface, level = bending_tube(12, 10, 3).surface;
    const auto pairs = paired_lines(original, level);
    const Neighbourhood a(original), b(level);
    double sum = 0;
    for (const LinePair& pair : pairs) {
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
    CHECK(sum == doctest::Approx(2 * 2 * 0.5 * (10 * 0.3 * 0.3 + 2) / area(level)));
  }

  TEST_CASE("a border is paired with the border, once, and what has no line like it with nothing") {
    const Surface original = sheet(12), level = sheet(4);
    const auto pairs = paired_lines(original, level);
    CHECK(pairs.size() == 2 * 4 * (4 + 12));
    for (const LinePair& pair : pairs) {
      const Vec3 x = Neighbourhood(level).at(level.position, pair.level);
      CHECK((x.x() == 0 || x.x() == 1 || x.y() == 0 || x.y() == 1));
    }
    Surface whole = bending_tube(24, 30, 3).surface;
    whole.attributes.col(whole.layout.uv_at(0)).setZero();  // no seam
    CHECK(paired_lines(whole, bending_tube(12, 10, 3).surface).empty());
    CHECK(paired_lines(bending_tube(24, 30, 3).surface, whole).empty());
  }
}
