// SPDX-License-Identifier: MIT
#include "pipeline/baseline.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

// Whether every vertex of `level` is one of `source`, with the same influences.
bool stands_on(const Surface& level, const Surface& source) {
  for (size_t v = 0; v < level.position.size(); ++v) {
    bool found = false;
    for (size_t u = 0; u < source.position.size() && !found; ++u)
      found = level.position[v] == source.position[u] && level.influences[v] == source.influences[u];
    if (!found) return false;
  }
  return true;
}

}  // namespace

TEST_SUITE("baseline") {
  TEST_CASE("meshopt_simplify comes to the triangles asked for and keeps vertices and weights as they were") {
    const Surface tube = bending_tube(16, 24, 4).surface;
    for (const int triangles : {400, 200, 100}) {
      const Surface level = meshopt_level(tube, triangles);
      CHECK(triangle_count(level) <= triangles);
      CHECK(triangle_count(level) >= triangles - 2);
      CHECK(border_edges(level) == 0);
      CHECK(stands_on(level, tube));
      CHECK(level.layout == tube.layout);
      CHECK(level.attributes.rows() == Eigen::Index(level.wedges.size()));
    }
  }
  TEST_CASE("something is left where meshopt_simplify would collapse all") {
    const Surface box = grid_box(Vec3(1, 1, 1), 1);
    const Surface level = meshopt_level(box, 1);
    CHECK(triangle_count(level) > 0);
    CHECK(triangle_count(level) < triangle_count(box));
  }
  TEST_CASE("polygons are cut first and all triangles stay where all are asked for") {
    const Surface box = grid_box(Vec3(1, 2, 3), 3);
    const Surface level = meshopt_level(box, triangle_count(box));
    CHECK(level.position == box.position);
    CHECK(level.corners == box.corners);
  }
  TEST_CASE("the source itself has no baseline error") {
    const Character tube = bending_tube(12, 16, 3);
    const PoseSet poses =
        choose_poses(tube, {.from_clips = 2, .range_of_motion = 0, .unseen_clip_frames = 2});
    const Chain chain = build_chain(tube, poses, {.targets = {{.ratio = 0.25}}});
    const Baseline baselines[] = {Baseline::MeshoptSimplify, Baseline::Endpoint};
    const auto measured = measure_baselines(tube, poses, chain.levels, baselines);
    REQUIRE(measured.size() == 2);
    for (const auto& levels : measured) {
      REQUIRE(levels.size() == 2);
      CHECK(levels[0].triangles == triangle_count(tube.surface));
      CHECK(levels[0].unseen_clip.max == 0);
      CHECK(levels[1].triangles <= triangle_count(chain.levels[1].surface));
      CHECK(levels[1].unseen_clip.rms > 0);
      CHECK(levels[1].unseen_motion.rms > 0);
    }
  }
}
