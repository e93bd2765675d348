// SPDX-License-Identifier: MIT
#include "pipeline/match.h"

#include <map>
#include <utility>

#include "pipeline/closest.h"
#include "pipeline/error.h"
#include "pipeline/pose.h"

namespace skinlod {
namespace {

// How far apart, in the character's diagonals, the middles of two boxes may be, and how much the diagonals
// may differ, before two surfaces cannot be meant to be the same.
constexpr double kElsewhere = 0.25;

// Points no farther apart than this share of the diagonal are at one place.
constexpr double kSamePlace = 1e-4;

// Things by their own name and that of what they belong to, or by their own alone; of several the first.
class ByName {
 public:
  void add(const std::string& of, const std::string& name, int thing) {
    by_both_.emplace(std::pair(of, name), thing);
    by_name_.emplace(name, thing);
  }
  /// -1: there is none.
  int find(const std::string& of, const std::string& name) const {
    if (const auto both = by_both_.find({of, name}); both != by_both_.end()) return both->second;
    const auto one = by_name_.find(name);
    return one != by_name_.end() ? one->second : -1;
  }

 private:
  std::map<std::pair<std::string, std::string>, int> by_both_;
  std::map<std::string, int> by_name_;
};

// Calls `visit` with each joint that has a node: the label of the node above, that of its own, and its
// number.
void for_each_joint(const Skeleton& skeleton, const auto& visit) {
  const std::vector<std::string> labels = node_labels(skeleton);
  for (int j = 0; j < int(skeleton.joints.size()); ++j) {
    const int node = skeleton.joints[j].node;
    if (node < 0) continue;
    const int parent = skeleton.nodes[node].parent;
    visit(parent < 0 ? "" : labels[parent], labels[node], j);
  }
}

// Per morph of the candidate, ours.
std::vector<int> match_morphs(const Character& character, const Character& candidate) {
  const auto node_of = [](const Character& c, const Morph& m) {
    return m.node < 0 ? "" : c.skeleton.nodes[m.node].name;
  };
  ByName ours;
  for (int m = 0; m < int(character.morphs.size()); ++m)
    ours.add(node_of(character, character.morphs[m]), character.morphs[m].name, m);
  std::vector<int> found;
  for (const Morph& morph : candidate.morphs)
    found.push_back(ours.find(node_of(candidate, morph), morph.name));
  return found;
}

// Where the nodes' axes are the same both maps lead to the node, so that their difference leads from one rest
// space to the other.
Affine between_binds(const Affine& ours, const Affine& theirs) {
  if (ours == theirs || !invertible(ours)) return identity();
  return compose(inverse(ours), theirs);
}

// Where the matched surface stands while the character is as it is bound.
std::vector<Vec3> still(const Character& character, const Matched& matched) {
  const Pose bind{"bind", Palette(character.skeleton.joints.size(), identity())};
  return pose_vertices(matched.surface, matched.posed(bind).palette);
}

// Two files' binds say no more than their product: other axes or units of the nodes (FBX in centimetres), or
// another rest space (a part bound elsewhere). The character itself tells which it is.
void share_rest_space_if_closer(const Character& character, Matched& matched) {
  const double near = kSamePlace * diagonal(character.surface.position);
  const std::vector<Vec3> placed = still(character, matched);
  bool differ = false;
  for (size_t v = 0; v < placed.size(); ++v)
    differ = differ || (placed[v] - matched.surface.position[v]).norm() > near;
  if (!differ) return;
  const Surface ours = triangulated(character.surface);
  const PosedSurface original(ours, ours.position);
  const auto off = [&](std::span<const Vec3> points) {
    double sum = 0;
    int guess = 0;
    for (const Vec3& x : points) {
      const ClosestPoint there = original.closest(x, guess);
      guess = there.face, sum += there.squared;
    }
    return sum;
  };
  if (!(off(matched.surface.position) < off(placed))) return;
  for (Matched::Counterpart& c : matched.joints) c.to_rest = identity();
}

struct Box {
  explicit Box(std::span<const Vec3> points) : low(points.front()), high(low) {
    for (const Vec3& x : points) low = low.cwiseMin(x), high = high.cwiseMax(x);
  }
  Vec3 low, high;
  double diagonal() const { return (high - low).norm(); }
};

void check_place(const Character& character, const Matched& matched, const std::string& name) {
  const Box ours(character.surface.position), theirs(still(character, matched));
  const double size = ours.diagonal();
  const double off = ((ours.low + ours.high) - (theirs.low + theirs.high)).norm() / 2;
  if (off <= kElsewhere * size && std::abs(theirs.diagonal() - size) <= kElsewhere * size) return;
  throw Error(Fault::Input, name + ": does not stand where the original does: its diagonal is " +
                                std::to_string(theirs.diagonal()) + " m and not " + std::to_string(size) +
                                ", its middle " + std::to_string(off) +
                                " m away: export it in the same units, way up and rest pose");
}

}  // namespace

Pose Matched::posed(const Pose& pose) const {
  Pose mine{pose.source, {}};
  for (const Counterpart& c : joints) mine.palette.push_back(compose(pose.palette[c.joint], c.to_rest));
  if (pose.morph_weights.empty()) return mine;
  for (const int m : morphs) mine.morph_weights.push_back(m < 0 ? 0 : pose.morph_weights[m]);
  return mine;
}

Matched match(const Character& character, const Character& candidate, Surface surface,
              const std::string& name) {
  const Skeleton& skeleton = candidate.skeleton;
  Matched matched{triangulated(surface), {}, match_morphs(character, candidate)};
  std::vector<bool> followed(skeleton.joints.size(), false);
  for (const Influences& influences : matched.surface.influences) {
    for (const Influence& i : influences) followed[i.joint] = true;
  }
  ByName ours;
  for_each_joint(character.skeleton,
                 [&](const std::string& of, const std::string& node, int j) { ours.add(of, node, j); });
  matched.joints.assign(skeleton.joints.size(), {0, identity()});
  std::vector<std::string> lost;
  for_each_joint(skeleton, [&](const std::string& of, const std::string& node, int j) {
    if (!followed[j]) return;
    const int found = ours.find(of, node);
    if (found < 0) {
      lost.push_back(node);
    } else {
      matched.joints[j] = {found, between_binds(character.skeleton.joints[found].inverse_bind,
                                                skeleton.joints[j].inverse_bind)};
    }
  });
  if (!lost.empty()) {
    throw Error(Fault::Input, name + ": " + std::to_string(lost.size()) +
                                  " of its joints are not in the original, '" + lost.front() +
                                  "' for one: joints are matched by name: write it with the "
                                  "original's node names (gltfpack: -kn)");
  }
  share_rest_space_if_closer(character, matched);
  check_place(character, matched, name);
  return matched;
}

}  // namespace skinlod
