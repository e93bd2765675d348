// SPDX-License-Identifier: MIT
#include "tests/formats/read_back.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "formats/gltf.h"
#include "pipeline/sections.h"
#include "tests/formats/scratch.h"

namespace skinlod {
namespace {

// A triangle begins at its smallest corner: writers may turn it.
std::array<int, 3> turned(std::array<int, 3> t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

// Every face of the level must be in the file, once and the same way round.
std::vector<int> matched_faces(const Surface& level, const ReadBack& back) {
  std::map<std::array<int, 3>, int> faces;
  for (int f = 0; f < level.face_count(); ++f) {
    const auto w = level.face(f);
    faces.emplace(turned({w[0], w[1], w[2]}), f);
  }
  REQUIRE(back.surface.face_count() == level.face_count());
  std::vector<int> matched;
  std::set<int> different;
  for (int f = 0; f < back.surface.face_count(); ++f) {
    const auto w = back.surface.face(f);
    const auto found = faces.find(turned({back.wedge[w[0]], back.wedge[w[1]], back.wedge[w[2]]}));
    REQUIRE(found != faces.end());
    matched.push_back(found->second), different.insert(found->second);
  }
  REQUIRE(different.size() == faces.size());
  return matched;
}

// The joint of `skeleton` that one of a written skeleton is: on the same node, or on the node above where a
// file must have a node for each of two joints, and bound in the same place.
int joint_in(const Skeleton& skeleton, const Skeleton& written, const Joint& joint) {
  for (int node = joint.node; node >= 0; node = written.nodes[node].parent) {
    for (size_t b = 0; b < skeleton.joints.size(); ++b) {
      const Affine& bind = skeleton.joints[b].inverse_bind;
      if (skeleton.joints[b].node == node &&
          (bind - joint.inverse_bind).norm() <= 1e-5 * (bind.norm() + joint.inverse_bind.norm()))
        return int(b);
    }
  }
  return -1;
}

}  // namespace

ReadBack as_it_is(const Surface& level) {
  ReadBack all{level, std::vector<int>(level.wedges.size()), std::vector<int>(size_t(level.face_count()))};
  std::iota(all.wedge.begin(), all.wedge.end(), 0);
  std::iota(all.face.begin(), all.face.end(), 0);
  return all;
}

ReadBack read_back(const Surface& level, const SlodLevel& stored) {
  ReadBack back{stored.surface, {}, {}};
  VertexInfluences influences;
  for (const Influences& i : level.influences) influences.push_back(round_weights(i));
  for (const Section& section : split(level, influences))
    back.wedge.insert(back.wedge.end(), section.wedges.begin(), section.wedges.end());
  REQUIRE(back.wedge.size() == back.surface.wedges.size());
  back.face = matched_faces(level, back);
  return back;
}

ReadBack read_back(const Surface& level, const Character& character, const GltfDocument* document) {
  const Scratch folder;
  const auto bytes = write_glb(character, level, document);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Character written = import_gltf(folder.file("level.glb", text)).character;

  ReadBack back{std::move(written.surface), {}, {}};
  std::map<std::pair<int, int>, std::set<int>> wedges;  // by node and part
  for (const int w : level.corners) {
    const int part = level.wedges[w].part;
    wedges[{character.parts[part].node, part}].insert(w);
  }
  for (const auto& [_, in_part] : wedges) back.wedge.insert(back.wedge.end(), in_part.begin(), in_part.end());
  REQUIRE(back.wedge.size() == back.surface.wedges.size());
  back.face = matched_faces(level, back);

  std::vector<int> joint;
  for (const Joint& its : written.skeleton.joints)
    joint.push_back(joint_in(character.skeleton, written.skeleton, its));
  for (Influences& influences : back.surface.influences) {
    for (Influence& i : influences) {
      i.joint = joint[i.joint];
      REQUIRE(i.joint >= 0);
    }
    std::ranges::sort(influences, {}, &Influence::joint);
  }
  return back;
}

}  // namespace skinlod
