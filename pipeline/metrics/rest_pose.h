// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/collapse.h"
#include "pipeline/metrics/rest_quadrics.h"

namespace skinlod {

/// Garland & Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997, on the rest pose.
///
///   cost(x) = x'(Q_u + Q_v)x     (their section 4)
///
/// The point is the minimum; weights are blended along the edge and cut to the largest. What everybody ships
/// today, and the line that the default metric is measured against.
///
/// We depart from the paper: planes are weighted by area; where the quadric is flat the point nearest to the
/// better of {ends, midpoint} is taken; pairs are edges only; weights are ours to carry, the paper has none.
class RestPoseMetric {
 public:
  using Placement = skinlod::Placement;

  RestPoseMetric(const Mesh& mesh, std::vector<Influences> influences);

  double estimate(const Mesh& mesh, Edge e, double) const { return quadrics_.estimate(mesh, e); }
  Placement place(const Mesh& mesh, Edge e) const { return quadrics_.place(mesh, e); }
  auto unsolved_places(const Mesh& mesh, Edge e) const { return quadrics_.unsolved_places(mesh, e); }
  bool turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const;
  size_t pose_count() const { return 1; }
  void commit(Edge e, const Placement& to) { quadrics_.commit(e, to); }

  /// Cuts every vertex to its `cap` largest influences from here on, 0 for no limit; returns what has
  /// changed.
  History limit_influences(const Mesh& mesh, int cap) { return quadrics_.limit_influences(mesh, cap); }

  const std::vector<Influences>& influences() const { return quadrics_.influences(); }

 private:
  RestQuadrics quadrics_;
};

}  // namespace skinlod
