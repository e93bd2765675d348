// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <set>
#include <tuple>

#include "pipeline/cook.h"
#include "pipeline/repair.h"
#include "tests/shapes.h"

using namespace skinlod;

namespace {

// The tube that ends at half its height, and what is above; both are open there and meet in a ring.
constexpr double kCut = 2;
Character lower() {
  return part_of(bending_tube(16, 24, 4), [](const Vec3& x) { return x.y() < kCut; });
}
Character upper() {
  return part_of(bending_tube(16, 24, 4), [](const Vec3& x) { return x.y() > kCut; });
}

Chain levels_of(const Character& character, Borders borders, Metric metric = Metric::Articulated,
                double coarsest = 0.15) {
  const CookOptions options{.poses = {.from_clips = 3, .range_of_motion = 1},
                            .chain = {.targets = {{.ratio = 0.4}, {.ratio = coarsest, .max_influences = 1}},
                                      .metric = metric,
                                      .borders = borders,
                                      .measured = false}};
  return cook(character, options).chain;
}

// All that a locked vertex promises to keep of a wedge: place, influences, normal and uv.
using Kept = std::tuple<double, double, double, std::vector<std::pair<int, double>>, std::vector<double>>;

std::set<Kept> on_the_cut(const Surface& surface, int max_influences) {
  const std::vector<char> locked = locked_vertices(surface, Borders::Locked);
  std::set<Kept> kept;
  for (size_t w = 0; w < surface.wedges.size(); ++w) {
    const int v = surface.wedges[w].vertex;
    if (!locked[size_t(v)]) continue;
    std::vector<std::pair<int, double>> influences;
    for (const auto& [joint, weight] : largest(surface.influences[size_t(v)], max_influences))
      influences.emplace_back(joint, weight);
    const auto row = surface.attributes.row(Eigen::Index(w));
    const Vec3& x = surface.position[size_t(v)];
    kept.emplace(x.x(), x.y(), x.z(), influences, std::vector<double>(row.begin(), row.end()));
  }
  return kept;
}

std::set<std::array<double, 3>> posed_cut(const Surface& surface, const Palette& palette) {
  const std::vector<char> locked = locked_vertices(surface, Borders::Locked);
  const std::vector<Vec3> posed = pose_vertices(surface, palette);
  std::set<std::array<double, 3>> points;
  for (size_t v = 0; v < posed.size(); ++v) {
    if (locked[v]) points.insert({posed[v].x(), posed[v].y(), posed[v].z()});
  }
  return points;
}

}  // namespace

TEST_SUITE("borders") {
  TEST_CASE("a locked border is the source's to the last bit in every level, whatever the metric") {
    Character source = lower();
    repair(source), weld(source);
    for (const Metric metric :
         {Metric::Articulated, Metric::PoseIndependent, Metric::Endpoint, Metric::RestPose}) {
      const Chain chain = levels_of(lower(), Borders::Locked, metric);
      REQUIRE(chain.levels.size() == 3);
      for (const Level& level : chain.levels) {
        CAPTURE(int(metric));
        CAPTURE(level.asked);
        CHECK(level.reached);
        const auto expected = on_the_cut(source.surface, level.max_influences);
        CHECK(expected.size() >= 17);  // the ring, and its seam once more
        CHECK(on_the_cut(level.surface, level.max_influences) == expected);
      }
      const Chain free = levels_of(lower(), Borders::Free, metric, 0.04);
      CHECK(on_the_cut(free.levels[2].surface, 1) != on_the_cut(source.surface, 1));
    }
  }

  TEST_CASE("parts cooked apart meet in every level and pose where their borders are locked") {
    const Character whole = bending_tube(16, 24, 4);
    const Chain a = levels_of(lower(), Borders::Locked), b = levels_of(upper(), Borders::Locked);
    const Chain free_a = levels_of(lower(), Borders::Free), free_b = levels_of(upper(), Borders::Free);
    for (size_t l = 0; l < a.levels.size(); ++l) {
      for (const double time : {0.0, 0.3, 0.9}) {
        CAPTURE(l);
        const Palette palette = sample(whole.skeleton, whole.clips[0], time);
        const auto cut = posed_cut(a.levels[l].surface, palette);
        CHECK(cut.size() == 16);
        CHECK(cut == posed_cut(b.levels[l].surface, palette));
        if (l < 2) continue;
        CHECK(posed_cut(free_a.levels[l].surface, palette) != posed_cut(free_b.levels[l].surface, palette));
      }
    }
  }
}
