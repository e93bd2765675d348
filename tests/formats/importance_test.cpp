// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "formats/import.h"
#include "pipeline/cook.h"
#include "tests/formats/scratch.h"
#include "tests/region.h"

using namespace skinlod;

namespace {

// A level under growing factors: its head gains triangles and comes closer to the source, the rest goes away.
void check_head(const std::string& path, const std::string& head) {
  Region before{.triangles = 0, .inside = 1e9, .outside = 0};
  double outside_at_first = 0;
  for (const double factor : {0.5, 1.0, 2.0, 4.0, 8.0}) {
    CAPTURE(factor);
    CookOptions options{.poses = {.from_clips = 2, .range_of_motion = 0, .unseen_clip_frames = 4},
                        .chain = {.targets = {{.ratio = 0.15}}, .source_level = false, .measured = false}};
    options.chain.importance = {{Importance::Of::Joints, head, factor}};
    const Cooked cooked = cook(import_character(path).character, options);
    const Level& level = cooked.chain.levels.front();
    const Region now = region(cooked.character, level.surface, cooked.poses.unseen_clip, head);
    CAPTURE(now.triangles);
    CAPTURE(before.triangles);
    CHECK(now.triangles > before.triangles);
    CHECK(now.inside < before.inside);
    CHECK(now.outside > 0.99 * before.outside);  // greedy collapse wavers by as much
    MESSAGE(path << ": factor " << factor << ": " << now.triangles << " of " << triangle_count(level.surface)
                 << " triangles, RMS " << 1000 * now.inside << " mm there and " << 1000 * now.outside
                 << " mm elsewhere");
    if (before.triangles == 0) outside_at_first = now.outside;
    before = now;
  }
  CHECK(before.outside > 1.05 * outside_at_first);
}

}  // namespace

TEST_SUITE("importance") {
  TEST_CASE("the humanoid's head grows finer and nothing else does") {
    check_head("content/humanoid.glb", "head*");
  }
  TEST_CASE("a real character's head grows finer and nothing else does") {
    if (const auto path = content("mannequiny/mannequiny.glb")) {
      check_head(*path, "head");
    } else {
      MESSAGE("skipped: mannequiny is not on this machine");
    }
  }
}
