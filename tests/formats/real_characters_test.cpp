// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "formats/import.h"
#include "formats/slod.h"
#include "pipeline/cook.h"
#include "pipeline/pack.h"
#include "tests/formats/scratch.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

// Sanitized builds take ten times as long: there the small characters stand for all.
#if defined(__SANITIZE_ADDRESS__)
constexpr int kLargest = 2000;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
constexpr int kLargest = 2000;
#else
constexpr int kLargest = 100000;
#endif
#else
constexpr int kLargest = 100000;
#endif

// What every level promises, whatever the file.
void check_levels(const std::string& path) {
  CAPTURE(path);
  Imported imported = import_character(path);
  if (triangle_count(imported.character.surface) > kLargest) return;
  const Cooked cooked =
      cook(std::move(imported.character),
           {.poses = {.unseen_clip_frames = 0, .unseen_range_of_motion = 0},
            .chain = {.targets = {{.ratio = 0.5}, {.ratio = 0.25}, {.ratio = 0.1, .max_influences = 2}}}});
  const Surface source = triangulated(cooked.character.surface);
  const std::vector<Level>& levels = cooked.chain.levels;
  REQUIRE(levels.size() == 4);

  const TurnedFaces found = turned_faces(source, cooked.chain.history, cooked.poses.examples);
  CHECK(found.turned == 0);
  CHECK(found.seen > 0);

  const auto bytes = pack(cooked.character, levels);
  const SlodFile file = read_slod(bytes, "packed");  // the loader refuses weights that do not sum to 255
  REQUIRE(file.levels.size() == levels.size());
  for (size_t l = 0; l < levels.size(); ++l) {
    CAPTURE(l);
    const Surface& level = levels[l].surface;
    CHECK((levels[l].reached ? triangle_count(level) <= levels[l].asked : !levels[l].reason.empty()));
    CHECK(border_edges(level) <= border_edges(source));
    CHECK(border_loops(level) <= border_loops(source));
    for (const Influences& influences : level.influences) {
      double sum = 0;
      bool positive = true;
      for (const auto& [joint, weight] : influences) positive &= weight > 0, sum += weight;
      const bool sound =
          positive && int(influences.size()) <= levels[l].max_influences && std::abs(sum - 1) < 1e-9;
      if (!sound) CHECK(sound);
    }

    // What the engine decodes, against what was cooked, at rest: positions have 16 bits of the level's box.
    const Surface& decoded = file.levels[l].surface;
    CHECK(triangle_count(decoded) == triangle_count(level));
    for (const Influences& influences : decoded.influences) {
      int sum = 0;
      for (const auto& [joint, weight] : influences) sum += int(std::lround(weight * 255));
      if (sum != 255) CHECK(sum == 255);
    }
    const Surface* other[] = {&decoded};
    const auto errors = posed_errors(level, other, std::span(cooked.poses.examples).first(1), 500);
    CHECK(total(errors.front()).max < 2e-5 * diagonal(source.position));
  }
}

}  // namespace

TEST_SUITE("real_characters") {
  TEST_CASE("every level of our own characters holds what it promises") {
    check_levels("content/humanoid.glb");
    check_levels("content/centipede.glb");
  }

  TEST_CASE("every level of other people's characters holds what it promises") {
    for (const char* file :
         {"arnaud/arnaud.fbx", "cesium_man/CesiumMan.dae", "cesium_man/CesiumMan.gltf", "fox/Fox.glb",
          "kaykit_knight/Knight.glb", "makehuman_female/mh_female.glb", "mannequiny/mannequiny.glb",
          "minetest_sam/sam.b3d", "ogre_ninja/ninja.mesh", "ogre_ninja/ninja.mesh.xml",
          "quaternius_dragon/YellowDragon.fbx", "rigged_figure/RiggedFigure.glb",
          "robot_expressive/RobotExpressive.glb", "rocketbox_female/Female_Adult_01_facial.fbx",
          "slime_fbx_ascii/maya_slime_7500_ascii.fbx", "wuson_x/Testwuson.X"}) {
      if (const auto path = content(file)) {
        check_levels(*path);
      } else {
        MESSAGE("SKIPPED: there is no " << file << ": set SKINLOD_CONTENT");
      }
    }
  }
}
