// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "formats/gltf.h"
#include "formats/slod.h"
#include "pipeline/closest.h"
#include "pipeline/cook.h"
#include "pipeline/pack.h"
#include "pipeline/repair.h"
#include "tests/formats/scratch.h"
#include "tests/packed_tube.h"

using namespace skinlod;

namespace {

size_t most_influences(const Surface& surface) {
  return std::ranges::max(surface.influences, {}, &Influences::size).size();
}

// How far the farthest vertex of `a` lies from `b` where both follow `palette`.
double apart(const Surface& a, const Surface& b, const Palette& palette) {
  const PosedSurface surface(b, pose_vertices(b, palette));
  double most = 0;
  for (const Vec3& x : pose_vertices(a, palette)) most = std::max(most, surface.closest(x).squared);
  return std::sqrt(most);
}

// Cooks under a cap of eight and of four, and reads the levels back from both files.
void check_eight(Imported imported, const Scratch& scratch) {
  const CookOptions options{
      .poses = {.from_clips = 2, .range_of_motion = 0, .unseen_clip_frames = 0, .unseen_range_of_motion = 0},
      .chain = {.targets = {{.ratio = 0.5, .max_influences = 8}}, .refine = 0, .measured = false}};
  const Cooked cooked = cook(std::move(imported.character), options);
  const Palette palette = cooked.poses.examples.back().palette;
  const double size = diagonal(cooked.character.surface.position);
  const auto packed = pack(cooked.character, cooked.chain.levels);
  const SlodFile slod = read_slod(packed, "packed");
  for (size_t l = 0; l < cooked.chain.levels.size(); ++l) {
    CAPTURE(l);
    const Surface& level = cooked.chain.levels[l].surface;
    REQUIRE(most_influences(level) > 4);

    CHECK(most_influences(slod.levels[l].surface) == most_influences(level));
    CHECK(apart(slod.levels[l].surface, level, palette) < 1e-3 * size);

    const auto bytes = write_glb(cooked.character, level, imported.document.get());
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    CHECK(text.find("JOINTS_1") != std::string::npos);
    CHECK(text.find("JOINTS_2") == std::string::npos);
    const std::string path = scratch.file("level.glb", text);
    Character back = import_gltf(path).character;
    repair(back);
    CHECK(most_influences(back.surface) == most_influences(level));
    CHECK(apart(back.surface, level, palette) < 1e-4 * size);

    // Without the second four the same surface is somewhere else.
    Surface halved = level;
    for (Influences& influences : halved.influences) {
      std::ranges::sort(influences, std::greater(), &Influence::weight);
      influences.resize(std::min<size_t>(influences.size(), 4));
      double sum = 0;
      for (const Influence& i : influences) sum += i.weight;
      for (Influence& i : influences) i.weight /= sum;
    }
    CHECK(apart(halved, level, palette) > 1e-3 * size);
  }
}

}  // namespace

TEST_SUITE("eight_influences") {
  TEST_CASE("eight influences come through both files from a generated shape") {
    Character c = bending_tube(16, 24, 8);
    for (size_t v = 0; v < c.surface.position.size(); ++v) {
      Influences& influences = c.surface.influences[v];
      influences.clear();
      for (int j = 0; j < 8; ++j) {
        const double away = c.surface.position[v].y() - j - 0.5;
        influences.push_back({j, 1 / (1 + away * away)});
      }
      double sum = 0;
      for (const Influence& i : influences) sum += i.weight;
      for (Influence& i : influences) i.weight /= sum;
    }
    const Scratch scratch;
    const auto bytes = write_glb(c, c.surface);
    check_eight(
        import_gltf(scratch.file("tube.glb", {reinterpret_cast<const char*>(bytes.data()), bytes.size()})),
        scratch);
  }

  TEST_CASE("eight influences come through both files from makehuman_female") {
    const auto path = content("makehuman_female/mh_female.glb");
    if (!path) {
      MESSAGE("SKIPPED: there is no makehuman_female/mh_female.glb: set SKINLOD_CONTENT");
      return;
    }
    const Scratch scratch;
    check_eight(import_gltf(*path), scratch);
  }
}
