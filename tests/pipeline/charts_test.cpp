// SPDX-License-Identifier: MIT
#include "pipeline/charts.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "pipeline/metrics/surface_quadrics.h"
#include "tests/shapes.h"

using namespace skinlod;

namespace {

using Line = std::array<int, 4>;  // both ends, both faces

std::vector<Line> found(const Surface& s) {
  std::vector<Line> lines;
  for (const SeamLine& line : seam_lines(s, Neighbourhood(s)))
    lines.push_back({line.edge.kept, line.edge.removed, line.faces[0], line.faces[1]});
  return lines;
}

std::vector<Line> held(const Surface& s) {
  std::vector<Line> lines;
  for (const HeldLine& line : held_lines(Mesh(s), {.border = 0, .seam = 1}))
    lines.push_back({line.edge.kept, line.edge.removed, line.faces[0], line.faces[1]});
  return lines;
}

}  // namespace

TEST_SUITE("charts") {
  TEST_CASE("the seams of a surface are those that a mesh holds") {
    const Surface tube = bending_tube(12, 10, 3).surface;
    CHECK(found(tube).size() == 10 + 2);
    CHECK(found(tube) == held(tube));
    Surface torn = tube;  // every third wedge has a uv of its own
    for (Eigen::Index w = 0; w < torn.attributes.rows(); w += 3)
      torn.attributes(w, torn.layout.uv_at(0)) += 0.5;
    CHECK(found(torn) == held(torn));
    CHECK(found(torn) != found(tube));
    CHECK(found(sheet(6)).empty());
  }

  TEST_CASE("the two sides of a card meet at its outline, not in a seam") {
    Surface card = sheet(2);
    const Surface front = card;
    for (int f = 0; f < front.face_count(); ++f) {
      std::vector<int> back;
      for (const int w : front.face(f)) {
        back.push_back(int(card.wedges.size()));
        card.wedges.push_back({front.wedges[w].vertex, 1});
      }
      std::reverse(back.begin(), back.end());
      card.add_face(back);
    }
    card.attributes = Rows::Zero(Eigen::Index(card.wedges.size()), card.layout.columns());
    CHECK(found(card) == held(card));
    CHECK(found(card).empty());
  }
}
