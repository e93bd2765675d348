// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "pipeline/collapse.h"
#include "pipeline/joint_lod.h"
#include "pipeline/metrics/morph_quadrics.h"
#include "pipeline/metrics/posed_books.h"
#include "pipeline/metrics/skinned_quadric.h"

namespace skinlod {

struct ArticulatedOptions {
  WeightRule weights = WeightRule::NonNegative;
  bool attributes = true;  // have a share in the error
};

/// Landreneau & Schaefer, "Simplification of Articulated Meshes", Eurographics 2009.
///
///   E_i(v, w) = sum_p q_i^p( sum_b w_b T_b^p v )     (their equation 3)
///
/// The position and the skin weights of the collapsed vertex are both unknowns. E is a quadratic of either
/// while the other is held, so the two are solved in turn (their sections 3.1 and 3.2), over the joints that
/// touch the edge's ends; the weights as the smallest offset from where they start.
///
/// We depart from the paper: planes are weighted by area, and borders and seams have planes of their own;
/// the rounds start from the cheapest of both ends and the midpoint, so that two are enough; weights are
/// held >= 0, which GPUs need and the paper does not ask; a ridge stands in for the pseudo-inverse; normals,
/// uvs and colours have a share in the error (Hoppe 1999), as the bind pose shows them. As in the paper, no
/// vertex ever has more than `cap` influences; but which are kept is chosen by what it costs to lose the
/// others, not by size (skinned_point.h).
///
/// Morph targets have a share in the error too, by what they add to the bind pose (morph_quadrics.h), and
/// their offsets are unknowns: the cost is as if each were one example pose more, with several on at a time.
///
/// Two ablations. Without a cap (the paper's own first form) influences add up from level to level.
/// `WeightRule::Signed` solves for weights as the paper prints them;
/// what comes of it can be posed and measured, but not packed or written: that is for the caller to mind.
class ArticulatedMetric {
 public:
  using Placement = skinlod::Placement;

  /// `poses` are the examples; `influences` those of the mesh's vertices.
  ArticulatedMetric(const Mesh& mesh, std::vector<Influences> influences, std::span<const Pose> poses,
                    ArticulatedOptions options = {});

  double estimate(const Mesh&, Edge e, double before) const;
  Placement place(const Mesh& mesh, Edge e) const;
  std::array<Placement, 3> unsolved_places(const Mesh& mesh, Edge e) const;
  bool turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const {
    return points_.turns_a_face(mesh, e, to) || morphs_.turns_a_face(mesh, e, to);
  }
  size_t pose_count() const { return points_.pose_count(); }
  void commit(Edge e, const Placement& to);

  /// Holds every vertex to at most `cap` influences from here on, 0 for no limit: the best are kept and
  /// their weights solved again, the vertex staying where it is. Returns what has changed.
  History limit_influences(const Mesh& mesh, int cap);

  /// Lets joints leave within `limit`, the vertices staying where they are.
  JointLod::Left let_leave(const Mesh& mesh, JointLod& joints, const JointLimit& limit);

  const std::vector<Influences>& influences() const { return influences_; }

 private:
  SkinnedQuadric error_of(const Mesh& mesh, Edge e) const;
  double error_of(const Mesh& mesh, int vertex, const Influences& influences) const;
  Influences reweighted(const Mesh& mesh, int vertex, const Influences& start,
                        const std::vector<int>& joints) const;

  ArticulatedOptions options_;
  std::vector<Influences> influences_;
  PosedPoints points_;
  PosedQuadrics quadrics_;
  MorphQuadrics morphs_;
  double morph_weight_;            // of what one target is off
  std::vector<Palette> palettes_;  // of the poses, and at rest: for attributes, which count as often as poses
  int cap_ = 0;                    // 0: no limit
};

}  // namespace skinlod
