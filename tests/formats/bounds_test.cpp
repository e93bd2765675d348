// SPDX-License-Identifier: MIT
#include "pipeline/bounds.h"

#include "formats/import.h"
#include "pipeline/cook.h"
#include "tests/formats/scratch.h"
#include "tests/posed_box.h"

using namespace skinlod;

namespace {

// Levels as a cook makes them, but for fitting: what counts here is whom their vertices follow.
void check_bounds(const std::string& path) {
  CAPTURE(path);
  const Cooked cooked = cook(import_character(path).character,
                             {.poses = {.unseen_clip_frames = 0, .unseen_range_of_motion = 0},
                              .chain = {.targets = {{.ratio = 0.1}}, .refine = 0, .measured = false}});
  const auto bytes = pack(cooked.character, cooked.chain.levels);
  const slod_file file = opened(bytes);
  REQUIRE(file.level_count == 2);
  for (std::uint32_t level = 0; level < file.level_count; ++level) {
    CAPTURE(level);
    const Held held = hold(file, level, level == 0 ? 500 : 10000);
    CHECK(held.outside == 0);
    CHECK(held.outside_shrunk > 0);
    const Looseness loose = looseness(file, level, cooked.character);
    CHECK(loose.outside == 0);
    CHECK(loose.outside_shrunk > 0);
    CHECK(loose.mean < 1.5);
    CHECK(loose.outside_clip_box == 0);
    CHECK(loose.outside_shrunk_clip_box > 0);
  }
}

}  // namespace

TEST_SUITE("bounds") {
  TEST_CASE("the bounds of real characters hold in any pose and are close in their clips") {
    for (const char* file : {"cesium_man/CesiumMan.gltf", "fox/Fox.glb", "ogre_ninja/ninja.mesh",
                             "rigged_figure/RiggedFigure.glb", "robot_expressive/RobotExpressive.glb"}) {
      if (const auto path = content(file)) {
        check_bounds(*path);
      } else {
        MESSAGE("SKIPPED: there is no " << file << ": set SKINLOD_CONTENT");
      }
    }
  }
}
