// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "pipeline/history.h"
#include "pipeline/quadric.h"

namespace skinlod {

/// The books of a metric with a single quadric per vertex, in rest space. The sum over an edge's ends says
/// cost and place; the weights are blended by how far along the edge the place lies, and cut to the largest.
class RestQuadrics {
 public:
  RestQuadrics(std::vector<Quadric> quadric, std::vector<Influences> influences);

  /// What `place` will cost, exactly.
  double estimate(const Mesh& mesh, Edge e) const;

  /// The minimum of the sum, closest to the cheapest of both ends and the midpoint.
  Placement place(const Mesh& mesh, Edge e) const;

  /// The midpoint and both ends.
  std::array<Placement, 3> unsolved_places(const Mesh& mesh, Edge e) const;

  void commit(Edge e, const Placement& to);

  /// Cuts every vertex to its `cap` largest influences from here on, 0 for no limit; returns what has
  /// changed.
  History limit_influences(const Mesh& mesh, int cap);

  const std::vector<Influences>& influences() const { return influences_; }

 private:
  Vec3 best_point(const Mesh& mesh, Edge e, const Quadric& q) const;
  Placement at(const Quadric& q, const Vec3& x, Edge e, double t) const;

  std::vector<Quadric> quadric_;
  std::vector<Influences> influences_;
  int cap_ = 0;  // 0: no limit
};

}  // namespace skinlod
