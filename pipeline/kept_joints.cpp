// SPDX-License-Identifier: MIT
#include "pipeline/kept_joints.h"

#include <algorithm>
#include <optional>

namespace skinlod {
namespace {

std::string without_digits(std::string name) {
  std::erase_if(name, [](char c) { return c >= '0' && c <= '9'; });
  return name;
}

// Exporters add these, with nothing on them: "hand_end" (Blender), "Bip01 HeadNub" (3ds Max), "HeadTop_End",
// and "Thumb4" below "Thumb3" (Mixamo).
bool is_bone_end(const std::string& name, const std::string& above) {
  for (const char* ending : {"End", "_end", ".end", " end", "Nub", "nub"}) {
    if (name.ends_with(ending)) return true;
  }
  return name != above && without_digits(name) == without_digits(above);
}

// The joint that all vertices of a part follow alone, if there is one.
std::vector<std::optional<int>> rigid_joints(const Surface& surface, size_t parts) {
  std::vector<std::optional<int>> joint(parts);
  std::vector<bool> is_rigid(parts, true);
  for (const Wedge& wedge : surface.wedges) {
    const Influences& its = surface.influences[wedge.vertex];
    if (its.empty()) continue;
    if (!joint[wedge.part]) joint[wedge.part] = its[0].joint;
    if (its.size() > 1 || its[0].joint != *joint[wedge.part]) is_rigid[wedge.part] = false;
  }
  for (size_t p = 0; p < parts; ++p) {
    if (!is_rigid[p]) joint[p].reset();
  }
  return joint;
}

}  // namespace

// Each star takes as little as lets the rest go on; where that fails, the last one takes one more.
bool matches(std::string_view pattern, std::string_view name) {
  size_t p = 0, n = 0, after_star = std::string_view::npos, taken = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      after_star = ++p, taken = n;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n])) {
      ++p, ++n;
    } else if (after_star != std::string_view::npos) {
      p = after_star, n = ++taken;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

std::vector<bool> kept_joints(const Character& character, const std::vector<std::string>& patterns) {
  const std::vector<Node>& nodes = character.skeleton.nodes;
  const std::vector<Joint>& joints = character.skeleton.joints;
  const std::vector<std::string> labels = joint_labels(character.skeleton);
  std::vector<bool> kept(joints.size(), false), has_vertices(joints.size(), false);
  std::vector<bool> is_leaf(nodes.size(), true), is_joint(nodes.size(), false), has_mesh(nodes.size(), false);
  for (const Influences& influences : character.surface.influences) {
    for (const Influence& i : influences) has_vertices[i.joint] = true;
  }
  for (const Node& node : nodes) {
    if (node.parent >= 0) is_leaf[node.parent] = false;
  }
  for (size_t b = 0; b < joints.size(); ++b) {
    is_joint[joints[b].node] = true;
    for (const std::string& pattern : patterns)
      if (matches(pattern, labels[b])) kept[b] = true;
  }
  const auto keep_holder_of = [&](int node) {
    for (int n = nodes[node].parent; n >= 0; n = nodes[n].parent) {
      bool found = false;
      for (size_t b = 0; b < joints.size(); ++b) {
        if (joints[b].node == n && has_vertices[b]) kept[b] = found = true;
      }
      if (found) return;
    }
  };
  const auto rigid = rigid_joints(character.surface, character.parts.size());
  for (size_t p = 0; p < rigid.size(); ++p) {
    const int node = character.parts[p].node;
    if (node >= 0) has_mesh[node] = true;
    if (!rigid[p]) continue;
    kept[*rigid[p]] = true;
    if (joints[*rigid[p]].node == node) keep_holder_of(node);
  }
  for (int n = 0; n < int(nodes.size()); ++n) {
    const int above = nodes[n].parent;
    if (above < 0 || !is_leaf[n] || is_joint[n] || has_mesh[n]) continue;
    if (!is_bone_end(nodes[n].name, nodes[above].name)) keep_holder_of(n);
  }
  return kept;
}

}  // namespace skinlod
