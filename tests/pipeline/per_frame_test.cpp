// SPDX-License-Identifier: MIT
#include "pipeline/metrics/per_frame.h"

#include <doctest/doctest.h>

#include "pipeline/collapse.h"
#include "pipeline/error.h"
#include "pipeline/evaluate.h"
#include "pipeline/metrics/articulated.h"
#include "pipeline/metrics/rest_pose.h"
#include "pipeline/parallel.h"
#include "pipeline/repair.h"
#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

const std::vector<int> kCounts = {600, 300, 100};

// The RMS distance of two surfaces as they stand, both at rest.
double rms_distance(const Surface& a, const Surface& b, int joints) {
  const Pose still{"bind", Palette(size_t(joints), identity())};
  const Surface* other[] = {&b};
  return posed_error(deviations(a, other, {&still, 1}).front()).rms;
}

}  // namespace

TEST_SUITE("per_frame") {
  TEST_CASE("on the rest pose it is rest_pose with seams free") {
    const Surface source = bending_tube(16, 24, 4).surface;
    const auto levels = simplify_frame(source, source.position, kCounts);
    const Surface bare = without_attributes(source);
    Mesh mesh(bare);
    RestPoseMetric metric(mesh, bare.influences);
    REQUIRE(levels.size() == kCounts.size());
    for (size_t l = 0; l < kCounts.size(); ++l) {
      collapse(mesh, metric, kCounts[l]);
      const Surface expected = mesh.surface(metric.influences());
      CHECK(levels[l].position == expected.position);
      CHECK(levels[l].corners == expected.corners);
    }
  }

  TEST_CASE("it hits its counts to a triangle and every frame has triangles of its own") {
    const Character c = bending_tube(16, 24, 4);
    std::vector<std::vector<int>> corners;
    for (unsigned p = 1; p <= 3; ++p) {
      const auto posed = pose_vertices(c.surface, random_palette(4, p, 0.5));
      const auto levels = simplify_frame(c.surface, posed, kCounts);
      for (size_t l = 0; l < kCounts.size(); ++l) {
        CHECK(triangle_count(levels[l]) <= kCounts[l]);
        CHECK(triangle_count(levels[l]) >= kCounts[l] - 1);
        CHECK(levels[l].attributes.cols() == 0);
        CHECK(border_edges(levels[l]) == 0);
      }
      corners.push_back(levels.back().corners);
    }
    CHECK(corners[0] != corners[1]);
    CHECK(corners[1] != corners[2]);
  }

  TEST_CASE("in its own frame it comes nearer than one level for all frames") {
    const Character c = bending_tube(24, 40, 5);
    std::vector<Pose> poses = {{"bind", Palette(5, identity())}};
    for (unsigned p = 1; p < 6; ++p) poses.push_back({"random", random_palette(5, p, 0.4)});
    const Surface bare = without_attributes(c.surface);
    Mesh mesh(bare);
    ArticulatedMetric metric(mesh, bare.influences, poses);
    const std::vector<int> count = {200};
    collapse(mesh, metric, count[0]);
    Surface level = mesh.surface(metric.influences());
    double ours = 0, reference = 0;
    for (const Pose& pose : poses) {
      Surface frame = bare, posed_level = level;
      frame.position = pose_vertices(bare, pose.palette);
      posed_level.position = pose_vertices(level, pose.palette);
      ours += rms_distance(frame, posed_level, 5);
      reference += rms_distance(frame, simplify_frame(bare, frame.position, count)[0], 5);
    }
    CHECK(reference > 0);
    CHECK(reference < ours);
  }

  TEST_CASE("one thread and two give the same surfaces") {
    const Character c = bending_tube(16, 24, 4);
    const auto posed = pose_vertices(c.surface, random_palette(4, 5, 0.5));
    const auto run = [&](int threads) {
      const ThreadLimit limit(threads);
      return simplify_frame(c.surface, posed, kCounts);
    };
    const auto one = run(1), two = run(2);
    for (size_t l = 0; l < kCounts.size(); ++l) {
      CHECK(one[l].position == two[l].position);
      CHECK(one[l].corners == two[l].corners);
    }
  }

  TEST_CASE("counts that ascend are refused") {
    const Surface s = tube(8, 4, 2);
    CHECK_THROWS_AS(simplify_frame(s, s.position, std::vector{10, 20}), Error);
  }
}
