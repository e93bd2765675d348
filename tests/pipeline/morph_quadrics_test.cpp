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
  CHECK(mesh.triangle_count() == triangles);
  return mesh.surface(metric.influences());
}

}  // namespace

TEST_SUITE("morph_quadrics") {
  TEST_CASE("a roof that a target raises from a plane comes back exactly") {
    const Surface source = sheet_with_roof(16);
    const Pose bind = morph_pose(-1, 1), raised = morph_pose(0, 1);
    const Mesh mesh(source);
    const Surface level =
        collapsed(source, ArticulatedMetric(mesh, source.influences, {&bind, 1}, {.attributes = false}), 16);
    CHECK(distance(source, level, bind) < 1e-6);
    CHECK(distance(source, level, raised) < 1e-6);
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

  TEST_CASE("an edge costs the mean over its poses and its offsets are the best there are") {
    const Surface s = morphing_tube();
    const Mesh mesh(s);
    const std::vector<Pose> poses = bent_poses();
    const ArticulatedMetric metric(mesh, s.influences, poses);
    std::vector<std::vector<Quadric>> skeletal, morphed;
    for (const Pose& pose : poses)
      skeletal.push_back(surface_quadrics(mesh, pose_vertices(s, pose.palette), held_lines(mesh)));
    for (int m = 0; m < 2; ++m) {
      const Pose pose = morph_pose(m, 2, 6);
      morphed.push_back(
          surface_quadrics(mesh, pose_vertices(s, pose.palette, pose.morph_weights), held_lines(mesh)));
    }
    const auto touches = [&](int v) {
      return std::ranges::any_of(mesh.faces_around(v), [&](int f) {
        return std::ranges::any_of(mesh.face(f), [&](int u) { return s.morphs[u].front().morph == 0; });
      });
    };
    int with_both = 0;
    for (const Edge e : mesh.edges()) {
      CAPTURE(e.kept);
      CAPTURE(e.removed);
      const bool first = touches(e.kept) || touches(e.removed);
      with_both += first;
      for (const Placement& to : {metric.place(mesh, e), Placement(metric.unsolved_places(mesh, e)[0])}) {
        double sum = 0;
        for (size_t p = 0; p < poses.size(); ++p) {
          const Quadric q = skeletal[p][e.kept] + skeletal[p][e.removed];
          sum += q(transform(blend(to.influences, poses[p].palette), to.position));
        }
        for (int m = first ? 0 : 1; m < 2; ++m) {
          const Quadric q = morphed[m][e.kept] + morphed[m][e.removed];
          sum += q(to.position + offset_of(*to.morphs, m));
        }
        sum += 4 * mesh.attribute_error(e)(to.position);
        const double expected = sum * 4 / (first ? 6 : 5);
        CHECK(to.cost == doctest::Approx(expected).epsilon(1e-6).scale(1e-6));
      }
      const Placement solved = metric.place(mesh, e);
      for (int m = first ? 0 : 1; m < 2; ++m) {
        const Quadric q = morphed[m][e.kept] + morphed[m][e.removed];
        const Quadric rest = skeletal[0][e.kept] + skeletal[0][e.removed];
        const Vec3 y = minimum(rest, solved.position) + offset_of(*solved.morphs, m);
        CHECK((q.A * y + q.b).norm() < 1e-6 * q.A.trace());
      }
    }
    CHECK(with_both > 50);
    CHECK(with_both < int(mesh.edges().size()) - 50);
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
