// SPDX-License-Identifier: MIT
#include "pipeline/morphs.h"

#include <doctest/doctest.h>

#include "pipeline/chain.h"
#include "pipeline/cook.h"
#include "tests/packed_tube.h"

using namespace skinlod;

namespace {

Vec3 up(double height) { return Vec3(0, 0, height); }

// The sheet with targets that raise it by as much as `heights` says: all its vertices, or only the first.
Surface raised(std::vector<double> heights) {
  Surface s = sheet(2);
  s.morphs.resize(s.position.size()), s.normal_morphs.resize(s.wedges.size());
  for (size_t m = 0; m < heights.size(); ++m) {
    for (size_t v = 0; v < s.position.size(); ++v)
      s.morphs[v].push_back({int(m), up(v == 0 ? heights[m] : heights[m] / 100)});
    s.normal_morphs[1].push_back({int(m), Vec3(1, 0, 0)});
  }
  return s;
}

}  // namespace

TEST_SUITE("morphs") {
  TEST_CASE("a blend has the morphs of either in order and none that cancels") {
    const MorphOffsets a = {{1, up(2)}, {4, up(1)}}, b = {{0, up(4)}, {4, up(-1)}};
    const MorphOffsets half = blend(a, b, 0.5);
    REQUIRE(half.size() == 2);
    CHECK(half[0].morph == 0);
    CHECK(half[0].delta == up(2));
    CHECK(half[1].morph == 1);
    CHECK(half[1].delta == up(1));
    CHECK(offset_of(a, 4) == up(1));
    CHECK(offset_of(a, 3) == Vec3::Zero());
    CHECK(offset_of({}, 0) == Vec3::Zero());
  }

  TEST_CASE("faint offsets go and a target with nothing left takes its normals with it") {
    Surface s = raised({1, 0.001, 0.5});
    CHECK(largest_offsets(s, 4) == std::vector<double>{1, 0.001, 0.5, 0});
    drop_faint_morphs(s, 0.006);
    CHECK(largest_offsets(s, 4) == std::vector<double>{1, 0, 0.5, 0});
    CHECK(s.morphs[0].size() == 2);
    CHECK(s.morphs[1].size() == 1);  // of the third only the first vertex is left
    CHECK(s.normal_morphs[1].size() == 2);
    drop_faint_morphs(s, 0.006, 0.7);
    CHECK(s.morphs[0].size() == 1);
    CHECK(s.morphs[0][0].delta == up(1));
    CHECK(s.morphs[1][0].delta == up(0.01));  // below the bar for targets, but its target is not
    drop_faint_morphs(s, 0, 2);
    CHECK(s.morphs.empty());
    CHECK(s.normal_morphs.empty());
  }

  TEST_CASE("a level keeps targets by how far they move it: all, the important, or none") {
    Character c = decorated_tube(24, 40);
    c.morphs.push_back({.name = "slight", .node = 5});
    c.morphs.push_back({.name = "faint", .node = 5});
    const double size = diagonal(c.surface.position);
    for (MorphOffsets& offsets : c.surface.morphs) {
      offsets.push_back({2, up(1e-4 * size)});
      offsets.push_back({3, up(0.5e-5 * size)});
    }
    const PoseOptions few{.from_clips = 2, .range_of_motion = 0, .unseen_clip_frames = 1};
    const auto largest = [&](MorphUse use) {
      const Cooked cooked = cook(c, {.poses = few, .chain = {.targets = {{.ratio = 0.05}}, .morphs = use}});
      CHECK(cooked.character.morphs.size() == (use == MorphUse::None ? 0 : 4));
      CHECK(cooked.poses.morphs.size() == (use == MorphUse::None ? 0 : 3));
      CHECK((cooked.chain.levels[1].morphs.rms > 0) == (use != MorphUse::None));
      const auto source = largest_offsets(cooked.chain.levels[0].surface, 4);
      CHECK((source[3] > 0) == (use != MorphUse::None));  // the source's own are left alone
      return largest_offsets(cooked.chain.levels[1].surface, 4);
    };
    const auto all = largest(MorphUse::Keep);
    CHECK(all[0] == doctest::Approx(0.3).epsilon(0.1));
    CHECK(all[1] == 0);
    CHECK(all[2] == doctest::Approx(1e-4 * size).epsilon(0.1));
    CHECK(all[3] == 0);
    const auto important = largest(MorphUse::Important);
    CHECK(important[0] == all[0]);
    CHECK(important[2] == 0);
    CHECK(largest(MorphUse::None) == std::vector<double>(4, 0));
  }
}
