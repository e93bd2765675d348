// SPDX-License-Identifier: MIT
#include "pipeline/metrics/morph_quadrics.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/evaluate.h"
#include "pipeline/metrics/articulated.h"
#include "pipeline/metrics/rest_pose.h"
#include "pipeline/metrics/surface_quadrics.h"
#include "pipeline/morphs.h"
#include "tests/random.h"
#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

// The bind pose with one of `count` targets on; none for -1.
Pose morph_pose(int morph, int count, int joints = 1) {
  Pose pose{"morph", Palette(size_t(joints), identity()), std::vector<double>(size_t(count), 0)};
  if (morph >= 0) pose.morph_weights[morph] = 1;
  return pose;
}

double distance(const Surface& a, const Surface& b, const Pose& pose) {
  const Surface* other[] = {&b};
  return spread(deviations(a, other, {&pose, 1}).front().front().distance).max;
}

// A flat sheet from which a target raises a roof along y, three tenths high.
Surface sheet_with_roof(int n) {
  Surface s = sheet(n);
  for (const Vec3& x : s.position) {
    const double height = 0.3 * std::max(0.0, 1 - std::abs(x.x() - 0.5) / 0.25);
    MorphOffsets& offsets = s.morphs.emplace_back();
    if (height > 0) offsets.push_back({0, Vec3(0, 0, height)});
  }
  return s;
}

// A tube that two targets deform: one swells its middle, the other makes it wavy all along.
Surface morphing_tube() {
  Surface s = bending_tube(12, 16, 6).surface;
  for (const Vec3& x : s.position) {
    MorphOffsets& offsets = s.morphs.emplace_back();
    if (std::abs(x.y() - 3) < 1) offsets.push_back({0, 0.5 * Vec3(x.x(), 0, x.z())});
    offsets.push_back({1, Vec3(0.4 * std::sin(3 * x.y()), 0, 0.2 * std::cos(5 * x.y()))});
  }
  return s;
}

std::vector<Pose> bent_poses() {
  std::vector<Pose> poses = {{"bind", Palette(6, identity())}};
  for (unsigned p = 1; p < 4; ++p) poses.push_back({"random", random_palette(6, p, 0.5)});
  return poses;
}

template <class M>
Surface collapsed(const Surface& source, M metric, int triangles) {
  Mesh mesh(source);
  collapse(mesh, metric, triangles);
  CHECK(mesh.triangle_count() <= triangles);
  CHECK(mesh.triangle_count() >= triangles - 1);  // most collapses take two
  return mesh.surface(metric.influences());
}

}  // namespace

TEST_SUITE("morph_quadrics") {
  TEST_CASE("a roof that a target raises from a plane comes back") {
    const Surface source = sheet_with_roof(16);
    const Pose bind = morph_pose(-1, 1), raised = morph_pose(0, 1);
    const Mesh mesh(source);
    const Surface level =
        collapsed(source, ArticulatedMetric(mesh, source.influences, {&bind, 1}, {.attributes = false}), 16);
    CHECK(distance(source, level, bind) < 1e-6);
    CHECK(distance(source, level, raised) < 2e-4);
    // At rest there is nothing to keep.
    const Surface flattened = collapsed(source, RestPoseMetric(mesh, source.influences), 16);
    CHECK(distance(source, flattened, bind) < 1e-6);
    CHECK(distance(source, flattened, raised) > 0.05);
  }

  TEST_CASE("a target that moves all alike comes back exactly") {
    Surface source = sphere(3);
    const Vec3 way(0.3, -2, 5);
    source.morphs.assign(source.position.size(), {{0, way}});
    const Pose bind = morph_pose(-1, 1);
    const Surface level =
        collapsed(source, ArticulatedMetric(Mesh(source), source.influences, {&bind, 1}), 60);
    for (const MorphOffsets& offsets : level.morphs) {
      REQUIRE(offsets.size() == 1);
      CHECK((offsets[0].delta - way).norm() < 1e-6);
    }
  }

  TEST_CASE("a target that slides the sheet along itself comes back") {
    const auto slide = [](const Vec3& x) { return 0.1 * std::max(0.0, 1 - std::abs(x.x() - 0.5) / 0.25); };
    Surface source = sheet(16);
    for (const Vec3& x : source.position) {
      MorphOffsets& offsets = source.morphs.emplace_back();
      if (slide(x) > 0) offsets.push_back({0, Vec3(0, slide(x), 0)});
    }
    const auto most_off = [&](const Surface& level) {
      double most = 0;
      for (int f = 0; f < level.face_count(); ++f) {
        Vec3 middle = Vec3::Zero(), offset = Vec3::Zero();
        for (const int v : triangle_vertices(level, f))
          middle += level.position[v] / 3, offset += offset_of(level.morphs[v], 0) / 3;
        most = std::max(most, (offset - Vec3(0, slide(middle), 0)).norm());
      }
      return most;
    };
    const Pose bind = morph_pose(-1, 1);
    const Mesh mesh(source);
    CHECK(most_off(collapsed(source, ArticulatedMetric(mesh, source.influences, {&bind, 1}), 16)) < 1e-4);
    CHECK(most_off(collapsed(source, RestPoseMetric(mesh, source.influences), 16)) > 0.02);
  }

  TEST_CASE("an edge is off by what its faces' offsets differ from the best ones") {
    const Surface s = morphing_tube();
    const Mesh mesh(s);
    const MorphQuadrics morphs(mesh);
    CHECK(morphs.count() == 2);
    // What a target adds at `x` by one face, and the face's area.
    const auto by_face = [&](int f, int morph, const Vec3& x) {
      Mat3 corners, offsets;
      for (int k = 0; k < 3; ++k) {
        const int v = mesh.face(f)[k];
        corners.col(k) = s.position[v], offsets.col(k) = offset_of(s.morphs[v], morph);
      }
      const Vec3 u = corners.col(1) - corners.col(0), v = corners.col(2) - corners.col(0), n = u.cross(v);
      Mat3 sides, rises;
      sides << u, v, n;
      rises << offsets.col(1) - offsets.col(0), offsets.col(2) - offsets.col(0), Vec3::Zero();
      const Vec3 there = offsets.col(0) + rises * sides.inverse() * (x - corners.col(0));
      return std::pair(there, n.norm() / 2);
    };
    int checked = 0;
    for (const Edge e : mesh.edges()) {
      const Vec3 x = 0.3 * s.position[e.kept] + 0.7 * s.position[e.removed] + Vec3(0, 0.1, 0);
      Placement best{.position = x, .influences = {}}, blended = best;
      morphs.solve(e, best);
      const double more = morphs.blend(mesh, e, blended);
      double sum = 0, sum_of_blended = 0;
      for (int m = 0; m < 2; ++m) {
        Vec3 mean = Vec3::Zero();
        double area = 0;
        std::vector<std::pair<Vec3, double>> all;
        for (const int end : {e.kept, e.removed}) {
          for (const int f : mesh.faces_around(end)) all.push_back(by_face(f, m, x));
        }
        for (const auto& [there, its] : all) mean += its * there, area += its;
        mean /= area;
        CHECK((offset_of(*best.morphs, m) - mean).norm() < 1e-3);
        for (const auto& [there, its] : all) {
          sum += its * (there - mean).squaredNorm();
          sum_of_blended += its * (there - offset_of(*blended.morphs, m)).squaredNorm();
        }
      }
      CHECK(morphs.error(e)(x) == doctest::Approx(sum).epsilon(1e-2));
      CHECK(morphs.error(e)(x) + more == doctest::Approx(sum_of_blended).epsilon(1e-2));
      checked += sum > 1e-4;
    }
    CHECK(checked > 100);
  }

  TEST_CASE("no face is turned over with a target on, which a metric that ignores them does") {
    Surface s = morphing_tube();
    std::mt19937 random(3);
    for (MorphOffsets& offsets : s.morphs) offsets.push_back({2, random_vector(random, 0.2)});
    std::vector<Pose> poses = bent_poses();
    for (int m = 0; m < 3; ++m) poses.push_back(morph_pose(m, 3, 6));
    const std::span<const Pose> skeletal(poses.data(), 4);

    Mesh mesh(s);
    ArticulatedMetric metric(mesh, s.influences, skeletal);
    const History history = collapse(mesh, metric, 80);
    CHECK(mesh.triangle_count() == 80);
    const TurnedFaces ours = turned_faces(s, history, poses);
    CHECK(ours.turned == 0);
    CHECK(ours.seen > 1000);

    Mesh other(s);
    RestPoseMetric rest(other, s.influences);
    CHECK(turned_faces(s, collapse(other, rest, 80), poses).turned > 0);
  }

  TEST_CASE("targets that move nothing change nothing") {
    const Surface bare = bending_tube(12, 16, 6).surface;
    Surface still = bare;
    still.morphs.resize(still.position.size());
    const std::vector<Pose> poses = bent_poses();
    const auto run = [&](const Surface& s) {
      Mesh mesh(s);
      ArticulatedMetric metric(mesh, s.influences, poses);
      return collapse(mesh, metric, 60);
    };
    const History a = run(bare), b = run(still);
    REQUIRE(a.size() > 100);
    REQUIRE(a.size() == b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      CHECK(a[i].edge == b[i].edge);
      CHECK(a[i].cost == b[i].cost);
      CHECK(a[i].position == b[i].position);
      CHECK(!a[i].morphs);
    }
  }
}
