// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "pipeline/collapse.h"
#include "pipeline/metrics/posed_books.h"

namespace skinlod {

/// Mohr & Gleicher, "Deformation Sensitive Decimation", University of Wisconsin technical report 2003, as
/// Landreneau & Schaefer 2009 (section 2) describe it.
///
///   cost(u, v) = min over x in {u, v} of sum_p (q_u^p + q_v^p)(x^p)     (x^p: where x stands in pose p)
///
/// The better end point is kept as it is, with its own influences: no vertex ever moves and no weight is
/// solved for, so every level's points are some of the source's.
///
/// We depart from the paper: planes are weighted by area, and borders and seams have planes of their own; a
/// collapse must turn no face over in any example pose; under a cap the source's vertices are cut to their
/// largest influences first.
class EndpointMetric {
 public:
  using Placement = skinlod::Placement;

  /// `poses` are the examples; `influences` those of the mesh's vertices.
  EndpointMetric(const Mesh& mesh, std::vector<Influences> influences, std::span<const Pose> poses);

  double estimate(const Mesh& mesh, Edge e, double before) const;
  Placement place(const Mesh& mesh, Edge e) const;
  std::array<Placement, 2> unsolved_places(const Mesh& mesh, Edge e) const;
  bool turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const {
    return points_.turns_a_face(mesh, e, to);
  }
  size_t pose_count() const { return points_.pose_count(); }
  void commit(Edge e, const Placement& to);

  /// Cuts every vertex to its `cap` largest influences, 0 for no limit; returns what has changed.
  History limit_influences(const Mesh& mesh, int cap);

  const std::vector<Influences>& influences() const { return influences_; }

 private:
  PosedPoints points_;
  PosedQuadrics quadrics_;
  std::vector<Influences> influences_;
};

}  // namespace skinlod
