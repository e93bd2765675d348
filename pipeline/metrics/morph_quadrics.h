// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "pipeline/history.h"
#include "pipeline/quadric.h"

namespace skinlod {

/// The morph targets of a mesh as example poses: each is the bind pose with one target at weight 1.
///
///   E_m(y) = q_m(y),   y = x + d_m     (q_m: the surface quadrics of the mesh with target m on)
///
/// The offset d_m is in no other pose, so that each is solved for by itself, whatever x is, at the cost of
/// one small factorisation: d_m = argmin q_m - argmin q_rest. Both minima, since a metric's x is seldom the
/// best for the bind pose alone: what that lacks is no business of the targets, which are played in all
/// poses, and one that moves nothing adds nothing.
///
/// A target is in the books of the vertices whose faces it moves; elsewhere what is known at rest stands for
/// it. The offsets themselves are the mesh's.
class MorphQuadrics {
 public:
  /// What a place of the kept vertex costs in all `poses` that an end of the edge has in its books.
  struct Cost {
    double sum = 0;
    int poses = 0;
  };

  explicit MorphQuadrics(const Mesh& mesh);

  /// Of the kept end where it is, and of the removed one.
  std::array<Cost, 2> at_ends(const Mesh& mesh, Edge e) const;

  /// Gives the placement the best offsets there are, where there are many those closest to the blend of the
  /// ends'.
  Cost solve(const Mesh& mesh, Edge e, Placement& to) const;

  /// Gives it the blend of the ends' offsets.
  Cost blend(const Mesh& mesh, Edge e, Placement& to) const;

  /// True where carrying the collapse out turns a face over with some target on.
  bool turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const;

  /// From here on the kept end has the sum.
  void merge(Edge e);

 private:
  struct Entry {
    int morph;
    Quadric q;
  };
  void for_each_sum(Edge e, const auto& take) const;

  std::vector<std::vector<Entry>> of_;  // per vertex, by ascending morph; none where the mesh has no morphs
  std::vector<Quadric> rest_;           // per vertex; none likewise
};

}  // namespace skinlod
