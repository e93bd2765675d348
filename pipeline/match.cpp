// SPDX-License-Identifier: MIT
#include "pipeline/match.h"

#include <map>

#include "pipeline/error.h"
#include "pipeline/pose.h"

namespace skinlod {
namespace {

// How far apart, in the character's diagonals, the middles of two boxes may be, and how much the diagonals
// may differ, before two surfaces cannot be meant to be the same.
constexpr double kElsewhere = 0.25;

std::map<std::string, int> first_joints(const Skeleton& skeleton) {
  const std::vector<std::string> labels = node_labels(skeleton);
  std::map<std::string, int> first;
  for (int j = 0; j < int(skeleton.joints.size()); ++j) {
    if (const int node = skeleton.joints[j].node; node >= 0) first.emplace(labels[node], j);
  }
  return first;
}

// Both maps lead to the node, so that their difference leads from one rest space to the other.
Affine between_binds(const Affine& ours, const Affine& theirs) {
  if (ours == theirs || !invertible(ours)) return identity();
  return compose(inverse(ours), theirs);
}

struct Box {
  explicit Box(std::span<const Vec3> points) : low(points.front()), high(low) {
    for (const Vec3& x : points) low = low.cwiseMin(x), high = high.cwiseMax(x);
  }
  Vec3 low, high;
  double diagonal() const { return (high - low).norm(); }
};

void check_place(const Character& character, const Matched& matched, const std::string& name) {
  const Palette still(character.skeleton.joints.size(), identity());
  const Box ours(character.surface.position), theirs(pose_vertices(matched.surface, matched.posed(still)));
  const double size = ours.diagonal();
  const double off = ((ours.low + ours.high) - (theirs.low + theirs.high)).norm() / 2;
  if (off <= kElsewhere * size && std::abs(theirs.diagonal() - size) <= kElsewhere * size) return;
  throw Error(Fault::Input, name + ": does not stand where the original does: its diagonal is " +
                                std::to_string(theirs.diagonal()) + " m and not " + std::to_string(size) +
                                ", its middle " + std::to_string(off) +
                                " m away: export it in the same units, way up and rest pose");
}

}  // namespace

Palette Matched::posed(const Palette& palette) const {
  Palette mine;
  for (const Counterpart& c : joints) mine.push_back(compose(palette[c.joint], c.to_rest));
  return mine;
}

Matched match(const Character& character, const Skeleton& skeleton, Surface surface,
              const std::string& name) {
  Matched matched{triangulated(surface), {}};
  std::vector<bool> followed(skeleton.joints.size(), false);
  for (const Influences& influences : matched.surface.influences) {
    for (const Influence& i : influences) followed[i.joint] = true;
  }
  const auto ours = first_joints(character.skeleton);
  const std::vector<std::string> labels = node_labels(skeleton);
  std::vector<std::string> lost;
  for (size_t j = 0; j < skeleton.joints.size(); ++j) {
    matched.joints.push_back({0, identity()});
    if (!followed[j]) continue;
    const Joint& theirs = skeleton.joints[j];
    const std::string& node = labels[theirs.node];
    const auto found = ours.find(node);
    if (found == ours.end()) {
      lost.push_back(node);
    } else {
      const Affine& bind = character.skeleton.joints[found->second].inverse_bind;
      matched.joints.back() = {found->second, between_binds(bind, theirs.inverse_bind)};
    }
  }
  if (!lost.empty()) {
    throw Error(Fault::Input, name + ": " + std::to_string(lost.size()) +
                                  " of its joints are not in the original, '" + lost.front() +
                                  "' for one: joints are matched by name: write it with the "
                                  "original's node names (gltfpack: -kn)");
  }
  check_place(character, matched, name);
  return matched;
}

}  // namespace skinlod
