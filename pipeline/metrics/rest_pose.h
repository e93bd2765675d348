// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "pipeline/collapse.h"
#include "pipeline/quadric.h"

namespace skinlod {

/// Garland & Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997, on the rest pose:
/// cost(x) = x'Qx over the summed quadrics of both ends; weights are blended along the edge and cut to the
/// largest. What everybody ships today, and the line that the default metric is measured against.
///
/// We depart from the paper: planes are weighted by area; where the quadric is flat the point nearest to the
/// better of {ends, midpoint} is taken; pairs are edges only; weights are ours to carry, the paper has none.
class RestPoseMetric {
 public:
  using Placement = skinlod::Placement;

  RestPoseMetric(const Mesh& mesh, std::vector<Influences> influences);

  Placement place(const Mesh& mesh, Edge e) const;
  std::array<Placement, 3> unsolved_places(const Mesh& mesh, Edge e) const;
  bool turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const;
  void commit(Edge e, const Placement& to);

  /// Cuts every vertex to its `cap` largest influences from here on; returns what has changed.
  History limit_influences(const Mesh& mesh, int cap);

  const std::vector<Influences>& influences() const { return influences_; }

 private:
  std::vector<Quadric> quadric_;
  std::vector<Influences> influences_;
  int cap_ = 0;  // 0: no limit
};

}  // namespace skinlod
