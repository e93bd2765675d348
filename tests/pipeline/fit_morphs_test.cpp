// SPDX-License-Identifier: MIT
#include "pipeline/fit_morphs.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "pipeline/morphs.h"
#include "tests/random.h"
#include "tests/shapes.h"

using namespace skinlod;

namespace {

void give(Surface& s, const auto& offset) {
  s.morphs.assign(s.position.size(), {});
  for (size_t v = 0; v < s.position.size(); ++v) {
    const Vec3 delta = offset(s.position[v]);
    if (!delta.isZero(0)) s.morphs[v].push_back({0, delta});
  }
}

Surface fitted(const Surface& original, const Surface& before, Surface level) {
  fit_morphs(original, before, paired(original, level), std::vector<char>(level.position.size(), 0), level);
  return level;
}

// Faces of `b` that look away from those of `a` with the target on.
int turned(const Surface& a, const Surface& b) {
  const auto normal = [](const Surface& s, int f) {
    std::array<Vec3, 3> x;
    for (size_t k = 0; k < 3; ++k) {
      const int v = triangle_vertices(s, f)[k];
      x[k] = s.position[v] + offset_of(s.morphs[v], 0);
    }
    return Vec3((x[1] - x[0]).cross(x[2] - x[0]));
  };
  int count = 0;
  for (int f = 0; f < a.face_count(); ++f) count += !(normal(a, f).dot(normal(b, f)) > 0);
  return count;
}

}  // namespace

TEST_SUITE("fit_morphs") {
  TEST_CASE("a target that turns and stretches the sheet comes back whatever the level had") {
    const auto offset = [](const Vec3& x) { return Vec3(0.3 * x.y(), -0.2 * x.x(), 0.5 + x.x()); };
    Surface original = sheet(16), before = sheet(5);
    give(original, offset);
    std::mt19937 random(1);
    give(before, [&](const Vec3& x) { return Vec3(offset(x) + random_vector(random, 0.05)); });
    Surface level = before;
    for (Vec3& x : level.position) x += Vec3(0, 0, uniform(random, -0.01, 0.01));
    level = fitted(original, before, std::move(level));
    for (size_t v = 0; v < level.position.size(); ++v) {
      const Vec3 x(level.position[v].x(), level.position[v].y(), 0);
      REQUIRE(level.morphs[v].size() == 1);
      CHECK((level.morphs[v][0].delta - offset(x)).norm() < 1e-3);
    }
  }

  TEST_CASE("what a target does not move stays without offsets") {
    const auto corner = [](const Vec3& x) { return Vec3(0, 0, std::max(0.0, 0.25 - x.x() - x.y())); };
    Surface original = sheet(16), level = sheet(8);
    give(original, corner), give(level, corner);
    level = fitted(original, level, level);
    int moved = 0;
    for (size_t v = 0; v < level.position.size(); ++v) {
      moved += !level.morphs[v].empty();
      if (level.position[v].x() + level.position[v].y() > 0.6) CHECK(level.morphs[v].empty());
    }
    CHECK(moved >= 3);
    CHECK(offset_of(level.morphs[0], 0).z() == doctest::Approx(0.25).epsilon(0.05));
  }

  TEST_CASE("lips part: the lower one's places that lie nearest to the upper are left out") {
    // Two sheets, a hair apart at y = 1; the target lifts the one beyond. The level's hair is a little off.
    const auto two = [](int n, double end) {
      Surface s = sheet(n), other = s;
      for (Vec3& x : s.position) x.y() *= end;
      for (Vec3& x : other.position) x.y() = end + 1e-3 + x.y() * (2 - end);
      const auto vertices = int(s.position.size());
      s.position.insert(s.position.end(), other.position.begin(), other.position.end());
      s.influences.insert(s.influences.end(), other.influences.begin(), other.influences.end());
      for (Wedge w : other.wedges) s.wedges.push_back({w.vertex + vertices, 0});
      const Rows one = s.attributes;
      s.attributes.resize(2 * one.rows(), one.cols());
      s.attributes << one, one;
      for (int f = 0; f < other.face_count(); ++f) {
        const auto face = other.face(f);
        s.add_face(std::array{face[0] + vertices, face[1] + vertices, face[2] + vertices});
      }
      s.morphs.assign(s.position.size(), {});
      for (size_t v = size_t(vertices); v < s.position.size(); ++v) s.morphs[v] = {{0, Vec3(0, 0, 0.3)}};
      return s;
    };
    const Surface original = two(16, 1);
    const Surface level = fitted(original, two(4, 1.03), two(4, 1.03));
    for (size_t v = 0; v < level.position.size(); ++v) {
      const double height = v < level.position.size() / 2 ? 0 : 0.3;
      CHECK(std::abs(offset_of(level.morphs[v], 0).z() - height) < 1e-6);
    }
  }

  TEST_CASE("no face is turned over with a target on, however it folds the original") {
    Surface original = sheet(16), before = sheet(8);
    std::mt19937 random(4);
    give(original, [&](const Vec3&) { return random_vector(random, 0.4); });
    give(before, [](const Vec3&) { return Vec3(0, 0, 1); });
    Surface level = before;
    for (Vec3& x : level.position) x += random_vector(random, 0.02);
    CHECK(turned(before, level) == 0);
    level = fitted(original, before, level);
    CHECK(turned(before, level) == 0);
    int fitted_ones = 0;  // some of the offsets are not those that vertices went back to
    for (size_t v = 0; v < level.position.size(); ++v) {
      const Vec3 y = level.position[v] + offset_of(level.morphs[v], 0);
      fitted_ones += (y - before.position[v] - Vec3(0, 0, 1)).norm() > 1e-3;
    }
    CHECK(fitted_ones > 0);
  }

  TEST_CASE("normals turn as the original's do") {
    Surface original = sheet(16), level = sheet(5);
    const auto give_normals = [](Surface& s, double size) {
      s.normal_morphs.assign(s.wedges.size(), {});
      for (size_t w = 0; w < s.wedges.size(); ++w)
        s.normal_morphs[w] = {{0, size * Vec3(s.position[s.wedges[w].vertex].x(), 0.5, 0)}};
    };
    give_normals(original, 1), give_normals(level, 0.8);
    level = fitted(original, level, level);
    for (size_t w = 0; w < level.wedges.size(); ++w) {
      const double x = level.position[level.wedges[w].vertex].x();
      CHECK((offset_of(level.normal_morphs[w], 0) - Vec3(x, 0.5, 0)).norm() < 1e-3);
    }
    CHECK(level.morphs.empty());
  }
}
