// SPDX-License-Identifier: MIT
#include "pipeline/match.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "pipeline/error.h"
#include "pipeline/evaluate.h"
#include "tests/random.h"
#include "tests/shapes.h"

using namespace skinlod;

namespace {

Palette sampled(const Character& c, double time) { return sample(c.skeleton, c.clips[0], time); }

void check_posed_alike(const Character& c, const Character& other) {
  const Matched matched = match(c, other, other.surface, "other");
  const Palette palette = sampled(c, 0.7);
  const auto expected = pose_vertices(c.surface, palette);
  const auto found = pose_vertices(matched.surface, matched.posed({"bent", palette}).palette);
  REQUIRE(found.size() == expected.size());
  for (size_t v = 0; v < expected.size(); ++v) CHECK((expected[v] - found[v]).norm() < 1e-12);
}

// The joints stand in the opposite order.
void turn_joints_round(Character& c) {
  const int last = int(c.skeleton.joints.size()) - 1;
  std::reverse(c.skeleton.joints.begin(), c.skeleton.joints.end());
  for (Influences& influences : c.surface.influences) {
    for (Influence& i : influences) i.joint = last - i.joint;
    std::reverse(influences.begin(), influences.end());
  }
}

std::string refused(const Character& original, const Character& other) {
  try {
    match(original, other, other.surface, "other.glb");
  } catch (const Error& e) {
    CHECK(e.fault == Fault::Input);
    return e.what();
  }
  return "";
}

}  // namespace

TEST_SUITE("match") {
  TEST_CASE("a character matched with itself is posed as it is") {
    const Character c = bending_tube(8, 8, 4);
    const Matched same = match(c, c, c.surface, "same");
    const Palette palette = sampled(c, 0.7);
    CHECK(same.posed({"bent", palette}).palette == palette);
  }

  TEST_CASE("joints without names are matched by where they stand in the order of the nodes") {
    Character c = bending_tube(8, 8, 4);
    for (Node& node : c.skeleton.nodes) node.name.clear();
    Character other = c;
    turn_joints_round(other);
    check_posed_alike(c, other);
    other.skeleton.nodes[size_t(other.skeleton.joints[1].node)].name = "somebody else's";
    CHECK(refused(c, other).find("'somebody else's'") != std::string::npos);
  }

  TEST_CASE("joints of one name are told apart by the nodes above") {
    Character c = bending_tube(8, 8, 4);
    REQUIRE(c.skeleton.joints.size() >= 4);
    const auto node_of = [&](size_t j) -> Node& {
      return c.skeleton.nodes[size_t(c.skeleton.joints[j].node)];
    };
    node_of(3).name = node_of(1).name;
    Character other = c;
    turn_joints_round(other);
    check_posed_alike(c, other);
    // Alone they are not.
    for (Node& node : other.skeleton.nodes) node.parent = -1;
    const Matched alone = match(c, other, other.surface, "other");
    CHECK(alone.joints[0].joint == alone.joints[2].joint);
  }

  TEST_CASE("joints in another order and another rest space are posed where the original is") {
    const Character c = bending_tube(8, 8, 4);
    Character other = c;
    turn_joints_round(other);
    const Vec3 offset(3, -2, 1);
    for (Joint& joint : other.skeleton.joints) {
      Affine bind = joint.inverse_bind;  // a rest space of half the size, elsewhere
      bind.leftCols<3>() *= 2;
      bind.col(3) -= joint.inverse_bind.leftCols<3>() * (2 * offset);
      joint.inverse_bind = bind;
    }
    for (Vec3& x : other.surface.position) x = x / 2 + offset;
    check_posed_alike(c, other);
  }

  TEST_CASE("joints with axes and units of their own are posed where the original is") {
    const Character c = bending_tube(8, 8, 4);
    Character other = c;
    std::mt19937 random(5);
    for (Joint& joint : other.skeleton.joints) {
      Affine frame = identity();
      frame.leftCols<3>() << 0, -0.01, 0, 0.01, 0, 0, 0, 0, 0.01;  // hundredfold, a quarter turn about z
      frame.col(3) = random_vector(random, 0.001);
      joint.inverse_bind = compose(frame, joint.inverse_bind);
    }
    check_posed_alike(c, other);
  }

  TEST_CASE("morphs are matched by their own and their nodes' names or by their own alone") {
    Character c = bending_tube(8, 8, 4);
    const int last = int(c.skeleton.nodes.size()) - 1;
    c.morphs = {{"smile", last}, {"smile", 0}, {"frown", 0}};
    Character other = c;
    other.morphs = {{"frown", last}, {"smile", 0}, {"wink", 0}, {"smile", 1}, {"smile", last}};
    const Matched matched = match(c, other, other.surface, "other");
    CHECK(matched.morphs == std::vector<int>{2, 1, -1, 0, 0});
    const Pose pose{"on", Palette(c.skeleton.joints.size(), identity()), {0.5, -1, 2}};
    CHECK(matched.posed(pose).morph_weights == std::vector<double>{2, -1, 0, 0.5, 0.5});
    CHECK(matched.posed({"off", pose.palette}).morph_weights.empty());
  }

  TEST_CASE("joints without a counterpart are named and counted") {
    const Character c = bending_tube(8, 8, 4);
    Character other = c;
    other.skeleton.nodes[other.skeleton.joints[1].node].name = "elbow";
    CHECK(refused(c, other).find("other.glb: 1 of its joints are not in the original, 'elbow'") == 0);
    other.skeleton.nodes[other.skeleton.joints[1].node].name = "";
    CHECK(refused(c, other).find("matched by name") != std::string::npos);
    for (Influences& influences : other.surface.influences) influences = {{0, 1.0}};
    CHECK(refused(c, other) == "");  // what no vertex follows need not be there
  }

  TEST_CASE("another size is no simplification") {
    const Character c = bending_tube(8, 8, 4);
    Character other = c;
    for (Vec3& x : other.surface.position) x *= 100;
    CHECK(refused(c, other).find("does not stand where the original does") != std::string::npos);
    other = c;
    for (Vec3& x : other.surface.position) x += Vec3(0, 0, 50);
    CHECK(refused(c, other).find("does not stand where the original does") != std::string::npos);
  }
}
