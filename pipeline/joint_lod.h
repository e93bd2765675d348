// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/character.h"
#include "pipeline/history.h"
#include "pipeline/pose.h"

/// Joints leave the levels of a chain, the cheapest first: what a far level does not follow need not be
/// animated for it.
namespace skinlod {

/// A joint that no vertex follows any more, and what it cost to let it go: how far that moved the surface off
/// the planes of the source, as the root of what it added to the mean square over all planes in all example
/// poses, metres. The costs of several joints add up in squares. Fitting the level takes some of it back.
struct LeftJoint {
  int joint;
  double cost;
};

/// What a level allows. Nothing leaves where neither is present.
struct JointLimit {
  std::optional<int> count{};     // at most so many joints stay, 1 or more
  std::optional<double> error{};  // metres: what all that have left so far may have cost together
};

/// What a vertex follows once it is without a joint, and how that changes the mean square, metres squared.
struct Refit {
  Influences influences;
  double rise = 0;
};

/// Lets joints leave, level after level. One that has left never returns.
///
/// What leaves is what costs least, and its cost is what its vertices lose when the weights of each are
/// solved again over the vertex's other joints, the nearest living joint above the one that leaves, and the
/// living joints that move most like it where its vertices are. Each that leaves changes the costs of those
/// that shared vertices with it, or counted on it; they are found again once the old ones come up. Of joints
/// that cost nothing, those deepest in the hierarchy go first, since only that saves their nodes too.
class JointLod {
 public:
  /// `must_stay`: per joint of the skeleton. `size`: of the character, metres.
  JointLod(const Skeleton& skeleton, std::span<const Pose> poses, std::vector<bool> must_stay, double size);

  /// The best for `vertex` over some of `joints` (ascending, at most kMaxJoints), searched from `start`.
  /// Calls run in parallel.
  using Solve = std::function<Refit(int vertex, const Influences& start, const std::vector<int>& joints)>;

  struct Left {
    std::vector<LeftJoint> joints{};  // in the order in which they went
    History changes{};                // of the vertices' influences
  };

  /// Lets joints leave the vertices of `mesh` until `limit` holds, or all that are left must stay.
  Left leave(const Mesh& mesh, std::vector<Influences>& influences, const JointLimit& limit,
             const Solve& solve);

 private:
  struct Offer {
    double cost = 0;                   // metres squared
    bool is_known = false;             // as far as nothing that the cost depends on has changed
    std::vector<int> heirs{};          // whom its vertices may come to follow; the first takes its weights
    std::vector<Influences> refits{};  // per vertex that follows it
  };

  void find_followers(const Mesh& mesh, std::span<const Influences> influences);
  bool is_alive(int joint) const { return !followers_[joint].empty(); }
  std::optional<int> cheapest() const;
  std::vector<int> heirs(int joint, const Mesh& mesh, std::span<const Influences> influences) const;
  Offer priced(int joint, const Mesh& mesh, std::span<const Influences> influences, const Solve& solve) const;
  void forget_costs(int joint, std::span<const Influences> influences);

  const Skeleton& skeleton_;
  std::span<const Pose> poses_;
  std::vector<bool> must_stay_;
  double nothing_;                           // metres squared: joints that cost less cost the same
  double spent_ = 0;                         // metres squared
  std::vector<int> depth_;                   // per joint: of its node
  std::vector<std::vector<int>> followers_;  // per joint: its vertices, ascending
  std::vector<Offer> offers_;                // per joint
};

/// How many joints the surface's vertices follow.
int joint_count(const Surface& surface);

}  // namespace skinlod
