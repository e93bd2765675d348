// SPDX-License-Identifier: MIT
#include "pipeline/metrics/pose_independent.h"

namespace skinlod {
namespace {

std::vector<Quadric> brought_to_rest(const Mesh& mesh, std::span<const Influences> influences,
                                     const PosedPoints& points) {
  const PosedQuadrics posed(mesh, points);
  std::vector<Quadric> rest(influences.size());
  parallel_for(mesh.vertex_count(), [&](int v) {
    for (size_t p = 0; p < points.pose_count(); ++p)
      rest[v] += pulled_back(posed.of(v)[p], blend(influences[v], points.palettes()[p]));
  });
  return rest;
}

}  // namespace

PoseIndependentMetric::PoseIndependentMetric(const Mesh& mesh, std::vector<Influences> influences,
                                             std::span<const Pose> poses)
    : points_(mesh, influences, poses), quadrics_(brought_to_rest(mesh, influences, points_), influences) {}

void PoseIndependentMetric::commit(Edge e, const Placement& to) {
  quadrics_.commit(e, to);
  points_.move(e.kept, to.position, to.influences);
}

History PoseIndependentMetric::limit_influences(const Mesh& mesh, int cap) {
  History changed = quadrics_.limit_influences(mesh, cap);
  points_.move(changed);
  return changed;
}

}  // namespace skinlod
