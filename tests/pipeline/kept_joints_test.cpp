// SPDX-License-Identifier: MIT
#include "pipeline/kept_joints.h"

#include <doctest/doctest.h>

#include "tests/shapes.h"

using namespace skinlod;

namespace {

using Names = std::vector<std::string>;

// The names of the joints that stay, in their order.
Names kept(const Character& c, const Names& patterns = {}) {
  Names names;
  const std::vector<bool> stays = kept_joints(c, patterns);
  for (size_t b = 0; b < stays.size(); ++b) {
    if (stays[b]) names.push_back(c.skeleton.nodes[size_t(c.skeleton.joints[b].node)].name);
  }
  return names;
}

// The tube of four joints with one more node.
Character with_node(const std::string& name, int parent) {
  Character c = bending_tube(12, 8, 4);
  c.skeleton.nodes.push_back({.name = name, .parent = parent});
  return c;
}

// A vertex of its own in a part of its own.
int add_prop(Character& c, int node, int joint) {
  c.parts.push_back({.name = "prop", .node = node, .has = c.surface.layout});
  c.surface.position.push_back(Vec3::Zero());
  c.surface.influences.push_back({{joint, 1.0}});
  c.surface.wedges.push_back({int(c.surface.position.size()) - 1, int(c.parts.size()) - 1});
  return c.surface.wedges.back().vertex;
}

}  // namespace

TEST_SUITE("kept_joints") {
  TEST_CASE("a star stands for any characters and a question mark for one") {
    for (const char* pattern :
         {"hand_l", "hand_*", "*_l", "*", "h*d*l", "hand_?", "??????", "*hand_l*", "**"}) {
      CAPTURE(pattern);
      CHECK(matches(pattern, "hand_l"));
    }
    for (const char* pattern : {"", "hand", "Hand_l", "hand_?l", "*_r", "?????", "hand_l?", "and*"}) {
      CAPTURE(pattern);
      CHECK_FALSE(matches(pattern, "hand_l"));
    }
    CHECK(matches("", ""));
    CHECK(matches("*", ""));
    CHECK_FALSE(matches("?", ""));
    const std::string name(200, 'a');
    CHECK_FALSE(matches("*a*a*a*a*a*a*a*a*a*a*a*a*b", name));  // does not take forever
  }

  TEST_CASE("nothing stays by itself in a skin without props") {
    const Character c = bending_tube(12, 8, 4);
    CHECK(kept(c).empty());
    CHECK(kept(c, {"joint1", "*3"}) == Names{"joint1", "joint3"});
    CHECK(kept(c, {"*"}).size() == 4);
    CHECK(kept(c, {"body"}).empty());  // a node, but no joint
  }

  TEST_CASE("what holds an attachment stays and what merely ends a bone does not count") {
    for (const char* name : {"hand_socket", "weapon", "camera", "spend"})
      CHECK(kept(with_node(name, 2)) == Names{"joint2"});
    for (const char* name : {"joint2_end", "HeadTop_End", "Bip01 HeadNub", "joint9"}) {
      CAPTURE(name);
      CHECK(kept(with_node(name, 2)).empty());
    }
    CHECK(kept(with_node("socket", -1)).empty());
    Character deeper = with_node("grip", 2);
    deeper.skeleton.nodes.push_back({.name = "muzzle", .parent = int(deeper.skeleton.nodes.size()) - 1});
    CHECK(kept(deeper) == Names{"joint2"});
  }

  TEST_CASE("an attachment on a joint without vertices is held by the next above that has some") {
    Character c = with_node("socket", 3);
    for (Influences& i : c.surface.influences) i = {{1, 1.0}};
    c.surface.influences[0] = {{0, 0.5}, {1, 0.5}};  // no rigid part
    CHECK(kept(c) == Names{"joint1"});
  }

  TEST_CASE("a rigid prop keeps its joint and what holds its node") {
    Character on_a_bone = bending_tube(12, 8, 4);
    const int vertex = add_prop(on_a_bone, 4, 2);
    CHECK(kept(on_a_bone) == Names{"joint2"});
    on_a_bone.surface.influences[size_t(vertex)] = {{1, 0.5}, {2, 0.5}};
    CHECK(kept(on_a_bone).empty());

    Character on_its_node = with_node("sword", 3);
    const int node = int(on_its_node.skeleton.nodes.size()) - 1;
    on_its_node.skeleton.joints.push_back({.node = node});
    add_prop(on_its_node, node, 4);
    CHECK(kept(on_its_node) == Names{"joint3", "sword"});
  }
}
