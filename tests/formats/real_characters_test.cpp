// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <tuple>

#include "formats/import.h"
#include "formats/slod.h"
#include "pipeline/cook.h"
#include "pipeline/kept_joints.h"
#include "pipeline/pack.h"
#include "pipeline/repair.h"
#include "tests/formats/read_back.h"
#include "tests/formats/scratch.h"
#include "tests/packed_tube.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

// Sanitized builds take twenty times as long: there the small characters stand for all.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitized = true;
#elif defined(__has_feature)
constexpr bool kSanitized = __has_feature(address_sanitizer);
#else
constexpr bool kSanitized = false;
#endif
constexpr int kLargest = kSanitized ? 1000 : 100000;  // triangles
constexpr int kDense = kSanitized ? 200 : 1500;       // points on a surface in a pose, and as many vertices

// Below so many triangles a character of several pieces may stop: each keeps four.
constexpr int kFewest = 30;

// What rounding in a file changes at the most: metres, shares of a vertex, and the uvs' own unit.
struct Steps {
  double position = 0, weight = 0, uv = 0;
};

// A .slod has half a step of its grids, and weights by largest remainder in 255ths.
Steps steps_of(const slod_file& file, std::uint32_t l, const Surface& level) {
  const auto half = [&](slod_kind kind, std::uint32_t set, int axes) {
    double squared = 0;
    const slod_chunk grid = slod_get_chunk(&file, slod_find(&file, l, kind, set));
    for (int c = 0; c < axes; ++c) squared += double(grid.step[c]) * double(grid.step[c]) / 4;
    return std::sqrt(squared);
  };
  Steps steps{half(SLOD_POSITION, 0, 3) + 1e-6 * diagonal(level.position), 1.0 / 255, 0};
  for (int set = 0; set < level.layout.uv_sets; ++set)
    steps.uv = std::max(steps.uv, 1.001 * half(SLOD_UV, std::uint32_t(set), 2));
  return steps;
}

// A GLB has floats.
Steps steps_of_glb(const Surface& level) {
  const AttributeLayout& layout = level.layout;
  const auto uvs = level.attributes.middleCols(layout.uv_at(0), 2 * layout.uv_sets);
  return {1e-6 * diagonal(level.position), 1e-6, uvs.size() > 0 ? 1e-7 * uvs.cwiseAbs().maxCoeff() : 0};
}

// How far those move a vertex in a pose: a weight wrong by d moves it by d times the way from one joint's
// place to the other's.
double reach(const Surface& s, int v, const Palette& palette, const Steps& steps) {
  const Affine blended = blend(s.influences[v], palette);
  const Vec3 here = transform(blended, s.position[v]);
  double sum = 0;
  for (const Influence& i : s.influences[v])
    sum += (transform(palette[i.joint], s.position[v]) - here).norm();
  return blended.leftCols<3>().norm() * steps.position + steps.weight * sum;
}

// Every vertex that the loader skins lies where the pipeline's does that it was made from.
void check_posed(const slod_file& file, std::uint32_t l, const Surface& level, std::span<const int> wedge,
                 const Steps& steps, const Pose& pose) {
  std::vector<float> rows;
  for (const Affine& m : pose.palette) {
    for (int i = 0; i < 12; ++i) rows.push_back(float(m(i / 4, i % 4)));
  }
  const auto rest = unpacked(file, l, SLOD_POSITION);
  auto posed = rest;
  slod_skin(&file, l, decoded<std::uint8_t>(file, l, SLOD_JOINT_INDEX).data(),
            decoded<std::uint8_t>(file, l, SLOD_WEIGHT).data(), rows.data(), posed.data(), nullptr);
  const auto expected = pose_vertices(level, pose.palette);
  int lost = 0;
  for (size_t i = 0; i < wedge.size(); ++i) {
    const int v = level.wedges[wedge[i]].vertex;
    lost += !((point(rest, i) - level.position[v]).norm() <= steps.position &&
              (point(posed, i) - expected[v]).norm() <= reach(level, v, pose.palette, steps));
  }
  CHECK(lost == 0);
}

// What there is of a level: the points of the source whole, and no face turned over, in no pose and no
// texture.
void check_whole(const ReadBack& found, const Surface& level, const Surface& source, const Traced& collapsed,
                 const PoseSet& poses, const Steps& steps) {
  std::vector<int> vertex, face;
  for (const int w : found.wedge) vertex.push_back(level.wedges[w].vertex);
  for (const int f : found.face) face.push_back(collapsed.face[f]);
  CHECK(cracks(found.surface, vertex) == 0);
  CHECK(turned_uvs(source, found.surface, face, steps.uv).turned == 0);
  const auto in_reach = [&](int v, const Palette& palette) {
    return reach(found.surface, v, palette, steps);
  };
  for (const auto* set : {&poses.examples, &poses.morphs})
    CHECK(turned_faces(collapsed.surface, found.surface, *set, found.face, in_reach).turned == 0);
}

// The farthest of kDense points of `from` at random places, and as many of its `vertices`, from `to`.
double farthest_of_many(const PosedSurface& from, std::span<const Vec3> vertices, const PosedSurface& to,
                        std::mt19937& random) {
  std::vector<double> area;
  for (int f = 0; f < from.surface().face_count(); ++f) area.push_back(from.normal(f).norm());
  std::discrete_distribution<int> any_face(area.begin(), area.end());
  std::uniform_real_distribution<double> unit(0, 1);
  double most = 0;
  const auto look = [&](const Vec3& x) { most = std::max(most, to.closest(x).squared); };
  for (int i = 0; i < kDense; ++i) {
    const int f = any_face(random);
    double u = unit(random), v = unit(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    look(from.at(f, Vec3(1 - u - v, u, v)));
  }
  const size_t each = 1 + vertices.size() / kDense;
  for (size_t v = random() % each; v < vertices.size(); v += each) look(vertices[v]);
  return std::sqrt(most);
}

// The largest error that is told is one that no other sampling exceeds in any pose, and not much more.
void check_bound(const Surface& source, const Level& level, const PoseSet& poses) {
  const double size = diagonal(source.position);
  const auto tree = std::make_shared<FaceTree>(source), other = std::make_shared<FaceTree>(level.surface);
  std::mt19937 random(7);
  double most = 0;
  for (const Pose& pose : poses.examples) {
    const auto there = pose_vertices(source, pose.palette, pose.morph_weights);
    const auto here = pose_vertices(level.surface, pose.palette, pose.morph_weights);
    const PosedSurface a(tree, there), b(other, here);
    most = std::max({most, farthest_of_many(a, there, b, random), farthest_of_many(b, here, a, random)});
  }
  CHECK(most <= level.examples.max + 1e-9 * size);
  CHECK(level.examples.max <= 1.5 * most + 1e-5 * size);
}

// Triangles and errors of a cook against the stored ones; each number has its own room beside it.
// SKINLOD_UPDATE_GOLDEN=1 stores today's numbers instead, for review.
void check_golden(const Cooked& cooked, const std::string& path) {
  const double percent = 100 / diagonal(cooked.character.surface.position);
  nlohmann::json now = nlohmann::json::array();
  for (const Level& level : cooked.chain.levels) {
    now.push_back({{"triangles", {{"is", triangle_count(level.surface)}, {"within", 2}}},
                   {"rms_percent", {{"is", level.examples.rms * percent}, {"within", 0.001}}},
                   {"max_percent", {{"is", level.examples.max * percent}, {"within", 0.02}}}});
  }
  if (std::getenv("SKINLOD_UPDATE_GOLDEN")) {
    std::ofstream(path) << now.dump(2) << '\n';
    return;
  }
  std::ifstream file(path);
  CAPTURE(path);
  REQUIRE(file);
  const auto golden = nlohmann::json::parse(file);
  REQUIRE(golden.size() == now.size());
  for (size_t l = 0; l < now.size(); ++l) {
    for (const auto& item : golden[l].items()) {
      CAPTURE(l);
      CAPTURE(item.key());
      const auto& value = item.value();
      CHECK(std::abs(now[l].at(item.key()).at("is").get<double>() - value.at("is").get<double>()) <=
            value.at("within").get<double>());
    }
  }
}

// Vertices that no pose tells from another before them: what coincides in the source must be one point.
int doubled(const Surface& s) {
  using Key = std::tuple<std::array<double, 3>, std::vector<std::pair<int, double>>,
                         std::vector<std::array<double, 4>>>;
  std::set<Key> known;
  for (size_t v = 0; v < s.position.size(); ++v) {
    const Vec3& x = s.position[v];
    Key key{{x.x(), x.y(), x.z()}, {}, {}};
    for (const auto& [joint, weight] : s.influences[v]) std::get<1>(key).emplace_back(joint, weight);
    if (!s.morphs.empty()) {
      for (const auto& [m, d] : s.morphs[v]) std::get<2>(key).push_back({double(m), d.x(), d.y(), d.z()});
    }
    known.insert(std::move(key));
  }
  return int(s.position.size() - known.size());
}

// What every level promises, whatever the file.
void check_levels(const std::string& path, const std::string& golden = "") {
  CAPTURE(path);
  Imported imported = import_character(path);
  const auto document = imported.document;
  if (triangle_count(imported.character.surface) > kLargest) {
    MESSAGE("SKIPPED: " << path << " is too large for a sanitized build");
    return;
  }
  const Cooked cooked =
      cook(std::move(imported.character),
           {.poses = {.unseen_clip_frames = 0, .unseen_range_of_motion = 0},
            .chain = {
                .targets = {
                    {.ratio = 0.5}, {.ratio = 0.25}, {.ratio = 0.1, .max_influences = 2}, {.ratio = 0.05}}}});
  const Surface source = triangulated(cooked.character.surface);
  const std::vector<Level>& levels = cooked.chain.levels;
  REQUIRE(levels.size() == 5);
  CHECK(doubled(source) == 0);

  const TurnedFaces found = turned_faces(source, cooked.chain.history, cooked.poses.examples);
  CHECK(found.turned == 0);
  CHECK(found.seen > 0);
  CHECK(turned_faces(source, cooked.chain.history, cooked.poses.morphs).turned == 0);

  if (!golden.empty()) check_golden(cooked, golden);

  const auto bytes = pack(cooked.character, levels);
  const slod_file packed = opened(bytes);
  const SlodFile file = read_slod(bytes, "packed");  // the loader refuses weights that do not sum to 255
  REQUIRE(file.levels.size() == levels.size());
  for (size_t l = 0; l < levels.size(); ++l) {
    CAPTURE(l);
    const Surface& level = levels[l].surface;
    const int asked = levels[l].asked, count = triangle_count(level);
    CHECK((levels[l].reached ? count <= asked : !levels[l].reason.empty()));
    CHECK((levels[l].reached || asked < kFewest));
    CHECK(asked - count <= std::max(2.0, 0.02 * asked));  // a collapse takes two
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
    const auto moved = deviations(level, other, std::span(cooked.poses.examples).first(1), {.samples = 500});
    CHECK(posed_error(moved.front()).max < 2e-5 * diagonal(source.position));
    check_bound(source, levels[l], cooked.poses);

    const ReadBack slod = read_back(level, file.levels[l]),
                   glb = read_back(level, cooked.character, document.get());
    const Steps steps = steps_of(packed, std::uint32_t(l), level);
    for (const Pose& pose : cooked.poses.examples)
      check_posed(packed, std::uint32_t(l), level, slod.wedge, steps, pose);
    const Traced collapsed = traced(source, cooked.chain.history, levels[l].steps);
    const auto check = [&](const ReadBack& its, const Steps& of_its) {
      check_whole(its, level, source, collapsed, cooked.poses, of_its);
    };
    check(as_it_is(level), {}), check(slod, steps), check(glb, steps_of_glb(level));
  }
}

// The names of the joints that must not leave the levels of a character.
std::set<std::string> kept_names(const std::string& path) {
  Character c = import_character(path).character;
  repair(c);
  const std::vector<bool> kept = kept_joints(c, {});
  std::set<std::string> names;
  for (size_t b = 0; b < kept.size(); ++b) {
    if (kept[b]) names.insert(c.skeleton.nodes[size_t(c.skeleton.joints[b].node)].name);
  }
  return names;
}

}  // namespace

TEST_SUITE("real_characters") {
  TEST_CASE("every level of our own characters holds what it promises") {
    check_levels("content/humanoid.glb", "tests/golden/humanoid.json");
    check_levels("content/centipede.glb", "tests/golden/centipede.json");
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

  TEST_CASE("props and the joints that hold them stay and the ends of bones hold nothing") {
    const auto fox = content("fox/Fox.glb"), knight = content("kaykit_knight/Knight.glb"),
               robot = content("robot_expressive/RobotExpressive.glb");
    if (!fox || !knight || !robot) {
      MESSAGE("SKIPPED: there are no other people's characters: set SKINLOD_CONTENT");
      return;
    }
    CHECK(kept_names(*fox).empty());
    CHECK(kept_names(*knight) == std::set<std::string>{"1H_Sword", "1H_Sword_Offhand", "2H_Sword",
                                                       "Badge_Shield", "Knight_Cape", "Knight_Helmet",
                                                       "Rectangle_Shield", "Round_Shield", "Spike_Shield",
                                                       "chest", "hand.l", "hand.r", "head"});
    const auto names = kept_names(*robot);
    CHECK(names.contains("Torso"));           // a rigid part
    CHECK_FALSE(names.contains("Index2.L"));  // which has "Index2.L_end" below it
  }
}
