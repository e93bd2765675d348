// SPDX-License-Identifier: MIT
#include "pipeline/metrics/endpoint.h"

#include <algorithm>

#include "pipeline/metrics/limit_influences.h"

namespace skinlod {

EndpointMetric::EndpointMetric(const Mesh& mesh, std::vector<Influences> influences,
                               std::span<const Pose> poses)
    : points_(mesh, influences, poses), quadrics_(mesh, points_), influences_(std::move(influences)) {}

std::array<Placement, 2> EndpointMetric::unsolved_places(const Mesh& mesh, Edge e) const {
  const auto along = quadrics_.along(e, points_);
  return {Placement{along.kept, mesh.position[e.kept], influences_[e.kept]},
          Placement{along.removed, mesh.position[e.removed], influences_[e.removed]}};
}

double EndpointMetric::estimate(const Mesh&, Edge e, double) const {
  const auto along = quadrics_.along(e, points_);
  return std::min(along.kept, along.removed);
}

Placement EndpointMetric::place(const Mesh& mesh, Edge e) const {
  const auto [kept, removed] = unsolved_places(mesh, e);
  return removed.cost < kept.cost ? removed : kept;
}

void EndpointMetric::commit(Edge e, const Placement& to) {
  quadrics_.merge(e);
  points_.move(e.kept, to.position, to.influences);
  influences_[e.kept] = to.influences;
}

History EndpointMetric::limit_influences(const Mesh& mesh, int cap) {
  History changed = skinlod::limit_influences(mesh, influences_, cap);
  points_.move(changed);
  return changed;
}

}  // namespace skinlod
