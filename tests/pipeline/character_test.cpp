// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <numeric>

#include "pipeline/character.h"
#include "pipeline/repair.h"

using namespace skinlod;

namespace {

// One polygon over the given points.
Surface polygon(const std::vector<Vec3>& points) {
  Surface s;
  s.position = points;
  for (int v = 0; v < int(points.size()); ++v) s.wedges.push_back({v, 0});
  std::vector<int> face(points.size());
  std::iota(face.begin(), face.end(), 0);
  s.add_face(face);
  return s;
}

// The areas of all triangles, signed by the side of +z they show.
std::vector<double> areas(const Surface& s) {
  std::vector<double> all;
  for (int f = 0; f < s.face_count(); ++f) {
    const auto c = s.face(f);
    REQUIRE(c.size() == 3);
    const auto& x = s.position;
    all.push_back((x[size_t(c[1])] - x[size_t(c[0])]).cross(x[size_t(c[2])] - x[size_t(c[0])]).z() / 2);
  }
  return all;
}

// Every triangle shows its front, and together they cover `area`.
void check_cover(const Surface& cut, int triangles, double area) {
  CHECK(cut.face_count() == triangles);
  double sum = 0;
  for (const double a : areas(cut)) {
    CHECK(a > 0);
    sum += a;
  }
  CHECK(sum == doctest::Approx(area).epsilon(1e-12));
}

std::vector<int> corners(const Surface& s, int f) { return {s.face(f).begin(), s.face(f).end()}; }

}  // namespace

TEST_SUITE("character") {
  TEST_CASE("a quad is cut along its shorter diagonal") {
    const Surface flat = triangulated(polygon({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {1, 1, 0}}));
    check_cover(flat, 2, 2);
    // The diagonals: 0-2 is sqrt(10) long, 1-3 is sqrt(2) long.
    CHECK(corners(flat, 0) == std::vector{3, 0, 1});
    CHECK(corners(flat, 1) == std::vector{1, 2, 3});
  }

  TEST_CASE("a concave quad is cut at its inner corner although that diagonal is longer") {
    // A dart: the corner 2 points inwards; 0-2 lies inside, the shorter 1-3 lies outside.
    const Surface dart = polygon({{0, 0, 0}, {1, 4, 0}, {0, 3, 0}, {-1, 4, 0}});
    const Surface cut = triangulated(dart);
    check_cover(cut, 2, 3);
    for (int f = 0; f < 2; ++f) {
      const auto c = corners(cut, f);
      CHECK(std::count(c.begin(), c.end(), 0) == 1);
      CHECK(std::count(c.begin(), c.end(), 2) == 1);
    }
  }

  TEST_CASE("a concave polygon is covered without a fold") {
    // A comb of 5 teeth: two corners a tooth and one between.
    std::vector<Vec3> comb = {{0, 0, 0}, {10, 0, 0}};
    for (int tooth = 4; tooth >= 0; --tooth) {
      comb.emplace_back(2 * tooth + 1.5, 5, 0);
      comb.emplace_back(2 * tooth + 0.5, 5, 0);
      if (tooth > 0) comb.emplace_back(2 * tooth, 1, 0);
    }
    double area = 0;
    for (size_t i = 0; i < comb.size(); ++i) area += comb[i].cross(comb[(i + 1) % comb.size()]).z() / 2;
    check_cover(triangulated(polygon(comb)), int(comb.size()) - 2, area);
  }

  TEST_CASE("a corner on a straight edge does not make a triangle without area") {
    check_cover(triangulated(polygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}})), 3, 4);
    // The straight corner lies on the very diagonal that the ear at the far corner would leave.
    check_cover(triangulated(polygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}})), 2, 1);
  }

  TEST_CASE("polygons without an ear and polygons of very many corners still become triangles") {
    const Surface flat = triangulated(polygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}}));
    CHECK(flat.face_count() == 3);

    const int n = 100000;
    std::vector<Vec3> circle;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      circle.emplace_back(std::cos(angle), std::sin(angle), 0);
    }
    CHECK(triangulated(polygon(circle)).face_count() == n - 2);
  }

  TEST_CASE("triangles pass through untouched and are counted as fans") {
    Surface s = polygon({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {-1, 0.5, 0}});
    s.add_face(std::array{2, 0, 1});
    CHECK(triangle_count(s) == 4);
    const Surface cut = triangulated(s);
    CHECK(triangle_count(cut) == 4);
    CHECK(cut.face_count() == 4);
    CHECK(corners(cut, 3) == std::vector{2, 0, 1});
    CHECK(triangle_count(Surface{}) == 0);
  }

  TEST_CASE("default attributes are up and right and white") {
    Eigen::RowVectorXd all(3 + 4 + 2 + 2 + 4);
    all << 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 0, 1, 1, 1, 1;
    CHECK(default_attributes({.normal = true, .tangent = true, .uv_sets = 2, .colour_sets = 1}) == all);
    CHECK(default_attributes({}).size() == 0);
    Eigen::RowVectorXd tangent(4);
    tangent << 1, 0, 0, 1;
    CHECK(default_attributes({.tangent = true}) == tangent);
  }

  TEST_CASE("a wider table has what the narrower had, in its columns, and defaults beside it") {
    const AttributeLayout narrow{.tangent = true, .uv_sets = 1}, other{.normal = true, .colour_sets = 1};
    const AttributeLayout wide = joined(narrow, other);
    CHECK(wide == AttributeLayout{.normal = true, .tangent = true, .uv_sets = 1, .colour_sets = 1});
    Rows table(1, 6);
    table << 0, 1, 0, -1, 0.25, 0.5;
    Rows expected(1, 13);
    expected << 0, 0, 1, 0, 1, 0, -1, 0.25, 0.5, 1, 1, 1, 1;
    CHECK(widened(table, narrow, wide) == expected);
    CHECK(widened(table, narrow, narrow) == table);
  }

  TEST_CASE("parts of one node, material and layout are drawn as the first of them, others as they are") {
    Character c;
    c.parts = {{.name = "a", .node = 1, .material = 0},
               {.name = "b", .node = 1, .material = 1},
               {.name = "c", .node = 2, .material = 0},
               {.name = "d", .node = 1, .material = 0},
               {.name = "e", .node = 1, .material = 0, .has = {.normal = true}}};
    for (int p = 0; p < 5; ++p) c.surface.wedges.push_back({0, p});
    merge_materials(c);
    std::vector<int> drawn_as;
    for (const Wedge& wedge : c.surface.wedges) drawn_as.push_back(wedge.part);
    CHECK(drawn_as == std::vector{0, 1, 2, 0, 4});
    CHECK(c.parts.size() == 5);
  }

  TEST_CASE("a clip lasts until its last key and the diagonal spans all positions") {
    Clip clip;
    CHECK(clip.duration() == 0);
    clip.channels = {{0, Path::Rotation, Interpolation::Linear, {0, 2.5}, Rows(2, 4)},
                     {0, Path::Scale, Interpolation::Step, {0, 1}, Rows(2, 3)},
                     {0, Path::Scale, Interpolation::Step, {}, Rows(0, 3)}};
    CHECK(clip.duration() == 2.5);
    CHECK(diagonal({}) == 0);
    CHECK(diagonal(std::vector<Vec3>{{1, 5, 0}, {0, 1, 12}, {3, 4, 3}}) == 13);
  }
}
