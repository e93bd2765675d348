// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/collapse.h"
#include "pipeline/metrics/posed_books.h"
#include "pipeline/metrics/rest_quadrics.h"

namespace skinlod {

/// DeCoro & Rusinkiewicz, "Pose-Independent Simplification of Articulated Meshes", I3D 2005, as Landreneau &
/// Schaefer 2009 (section 2) describe it.
///
///   Q_i = sum_p (T_i^p)' q_i^p T_i^p,   T_i^p = sum_b w_ib T_b^p,   cost(x) = x'(Q_u + Q_v)x
///
/// The posed quadrics are brought back to rest space by the transforms of their own vertex and added up, so
/// that one per vertex is kept however many poses there are. The point is the minimum; weights are blended by
/// distance along the edge. What is lost: an edge's two quadrics were brought back by different transforms,
/// and no cost knows of the weights.
///
/// We depart from the paper: the poses are the cook's examples, each counted once, where the paper draws them
/// from a probability over joint angles; the transform is the blended matrix as it is, with its shear, and
/// the quadric is pulled back without an inverse; planes are weighted by area, and borders and seams have
/// planes of their own; weights are cut to the largest; a collapse must turn no face over in any example
/// pose, as for all metrics that know the poses, so that what differs is the cost alone.
class PoseIndependentMetric {
 public:
  using Placement = skinlod::Placement;

  /// `poses` are the examples; `influences` those of the mesh's vertices.
  PoseIndependentMetric(const Mesh& mesh, std::vector<Influences> influences, std::span<const Pose> poses);

  double estimate(const Mesh& mesh, Edge e, double) const { return quadrics_.estimate(mesh, e); }
  Placement place(const Mesh& mesh, Edge e) const { return quadrics_.place(mesh, e); }
  auto unsolved_places(const Mesh& mesh, Edge e) const { return quadrics_.unsolved_places(mesh, e); }
  bool turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const {
    return points_.turns_a_face(mesh, e, to);
  }
  size_t pose_count() const { return points_.pose_count(); }
  void commit(Edge e, const Placement& to);

  /// Cuts every vertex to its `cap` largest influences from here on, 0 for no limit; returns what has
  /// changed.
  History limit_influences(const Mesh& mesh, int cap);

  const std::vector<Influences>& influences() const { return quadrics_.influences(); }

 private:
  PosedPoints points_;
  RestQuadrics quadrics_;
};

}  // namespace skinlod
