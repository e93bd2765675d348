// SPDX-License-Identifier: MIT
#include "pipeline/fit_attributes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "pipeline/charts.h"
#include "pipeline/mesh.h"
#include "tests/random.h"
#include "tests/shapes.h"

using namespace skinlod;

namespace {

bool on_border(const Vec3& x) { return x.x() == 0 || x.x() == 1 || x.y() == 0 || x.y() == 1; }

// Uvs are turned over where a face's are against the original's hand.
int turned_over(const Surface& s) {
  int count = 0;
  for (int f = 0; f < s.face_count(); ++f) {
    const auto w = s.face(f);
    const auto uv = [&](int k) -> Vec2 { return s.attributes.row(w[k]).segment<2>(s.layout.uv_at(0)); };
    const Vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
    count += a.x() * b.y() - a.y() * b.x() > 0;
  }
  return count;
}

// `count` sheets one over the other at the heights that `height` gives, each with a chart of its own beside
// the others'.
Surface layers(int n, int count, const std::function<double(int layer, const Vec3& x)>& height) {
  Surface all = sheet(n);
  const Surface one = all;
  all.position.clear(), all.influences.clear(), all.wedges.clear(), all.corners.clear();
  all.face_begin = {0};
  all.attributes = one.attributes.replicate(count, 1);
  for (int layer = 0; layer < count; ++layer) {
    const int first = int(all.position.size());
    for (size_t v = 0; v < one.position.size(); ++v) {
      const Vec3& x = one.position[v];
      all.position.push_back(Vec3(x.x(), x.y(), height(layer, x)));
      all.influences.push_back({{0, 1.0}});
      all.wedges.push_back({int(all.position.size()) - 1, 0});
      all.attributes(first + Eigen::Index(v), all.layout.uv_at(0)) += 0.1 * layer;
    }
    for (int f = 0; f < one.face_count(); ++f) {
      const auto w = one.face(f);
      all.add_face(std::array{first + w[0], first + w[1], first + w[2]});
    }
  }
  return all;
}

void fit(const Surface& original, const Surface& before, Surface& level) {
  fit_attributes(original, before, paired_in_charts(original, level, paired(original, level)),
                 locked_vertices(level, Borders::Free), level);
}

}  // namespace

TEST_SUITE("fit_attributes") {
  TEST_CASE("a layer keeps its own texture where it comes nearer to the next") {
    const Surface original = layers(12, 2, [](int layer, const Vec3&) { return 0.02 * layer; });
    const Surface level =
        layers(3, 2, [](int layer, const Vec3& x) { return layer == 0 ? 0.019 * x.x() : 0.02; });
    Surface fitted = level;
    fit(original, level, fitted);
    const int u = level.layout.uv_at(0);
    double most = 0;
    for (Eigen::Index w = 0; w < level.attributes.rows(); ++w)
      most = std::max(most, std::abs(fitted.attributes(w, u) - level.attributes(w, u)));
    CAPTURE(most);
    CHECK(most < 0.01);
  }

  TEST_CASE("uvs follow points that slide in their plane") {
    const Surface original = sheet(16), before = sheet(6);
    Surface level = before;
    std::mt19937 random(2);
    for (Vec3& x : level.position) {
      if (!on_border(x)) x += Vec3(uniform(random, -0.05, 0.05), uniform(random, -0.05, 0.05), 0);
    }
    fit(original, before, level);
    for (Eigen::Index w = 0; w < level.attributes.rows(); ++w) {
      const Vec3& x = level.position[size_t(w)];
      const Vec2 uv = level.attributes.row(w).segment<2>(level.layout.uv_at(0)).transpose();
      CHECK((uv - Vec2(0.2 + 0.5 * x.x(), 0.9 - 0.5 * x.y())).norm() < 1e-3);
    }
  }

  TEST_CASE("normals become those of the original; handedness stays") {
    const Surface original = sheet(16), before = sheet(6);
    Surface level = before;
    Surface start = before;
    std::mt19937 random(3);
    for (Surface* s : {&level, &start}) {
      for (Eigen::Index w = 0; w < s->attributes.rows(); ++w) {
        const Vec3 n = (Vec3(0, 0, 1) + random_vector(random, 0.3)).normalized();
        s->attributes.row(w).segment<3>(0) = n.transpose();
      }
    }
    fit(original, start, level);
    for (Eigen::Index w = 0; w < level.attributes.rows(); ++w) {
      CHECK(level.attributes.row(w).segment<3>(0).norm() == doctest::Approx(1));
      CHECK(level.attributes(w, 2) > 0.9999);
      const Vec3 n = level.attributes.row(w).segment<3>(0), t = level.attributes.row(w).segment<3>(3);
      CHECK(std::abs(n.dot(t)) < 1e-9);
      CHECK(level.attributes(w, 6) == -1);
    }
  }

  TEST_CASE("facets keep the normals of their faces") {
    Surface level = sheet(4);
    const Surface original = sheet(16), before = level;
    for (Vec3& x : level.position) x = Vec3(x.x(), x.y(), 0.1 * x.x());
    fit(original, before, level);
    const Vec3 n = Vec3(-0.1, 0, 1).normalized();
    for (Eigen::Index w = 0; w < level.attributes.rows(); ++w)
      CHECK((level.attributes.row(w).segment<3>(0).transpose() - n).norm() < 1e-9);
  }

  TEST_CASE("what is across a seam is not looked at, and wedges with the same uvs stay together") {
    // Halves of the sheet in two charts: the far half's uvs are elsewhere. The level's seam lies on it.
    const auto two_charts = [](int n) {
      Surface s = sheet(n);
      const int wedges = int(s.wedges.size());
      for (int w = 0; w < wedges; ++w) s.wedges.push_back(s.wedges[w]);
      const Rows one = s.attributes;
      s.attributes.resize(2 * wedges, one.cols());
      s.attributes << one, one;
      s.attributes.bottomRows(wedges).middleCols(s.layout.uv_at(0), 2).array() += 5;
      for (int f = 0; f < s.face_count(); ++f) {
        const auto v = triangle_vertices(s, f);
        if (s.position[v[0]].x() + s.position[v[1]].x() + s.position[v[2]].x() < 1.5) continue;
        for (size_t k = 0; k < 3; ++k) s.corners[size_t(3 * f) + k] += wedges;
      }
      return s;
    };
    Surface original = two_charts(16), before = two_charts(4);
    const auto tilt = [](Surface& it, double by) {
      for (Eigen::Index w = 0; w < it.attributes.rows(); ++w) {
        const double x = it.position[it.wedges[size_t(w)].vertex].x();
        it.attributes.row(w).segment<3>(0) = Vec3(0.3 + by * x, 0, 1).normalized().transpose();
      }
    };
    tilt(original, 1), tilt(before, 0);
    Surface level = before;
    fit(original, before, level);
    for (int f = 0; f < level.face_count(); ++f) {
      for (const int w : level.face(f)) {
        const Vec3& x = level.position[level.wedges[w].vertex];
        const bool far = level.attributes(w, level.layout.uv_at(0)) > 3;
        const Vec2 uv = level.attributes.row(w).segment<2>(level.layout.uv_at(0)).transpose();
        CHECK((uv - Vec2(0.2 + 0.5 * x.x() + 5 * far, 0.9 - 0.5 * x.y() + 5 * far)).norm() < 1e-3);
        CHECK(std::abs(level.attributes(w, 0) / level.attributes(w, 2) - 0.3 - x.x()) < 0.05);
      }
    }
    const auto half = level.attributes.rows() / 2;  // the same vertices in the other chart
    CHECK(level.attributes.leftCols(3).topRows(half) == level.attributes.leftCols(3).bottomRows(half));
  }

  TEST_CASE("no uv triangle is turned over, however the original's uvs fold") {
    Surface original = sheet(16);
    std::mt19937 random(4);
    for (Eigen::Index w = 0; w < original.attributes.rows(); ++w) {
      for (int k = 0; k < 2; ++k)
        original.attributes(w, original.layout.uv_at(0) + k) += uniform(random, -0.1, 0.1);
    }
    const Surface before = sheet(8);
    CHECK(turned_over(before) == 0);
    Surface level = before;
    fit(original, before, level);
    CHECK(turned_over(level) == 0);
    CHECK(level.attributes != before.attributes);
  }
}
