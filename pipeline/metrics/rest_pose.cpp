// SPDX-License-Identifier: MIT
#include "pipeline/metrics/rest_pose.h"

#include <algorithm>

#include "pipeline/metrics/surface_quadrics.h"

namespace skinlod {

RestPoseMetric::RestPoseMetric(const Mesh& mesh, std::vector<Influences> influences)
    : quadrics_(surface_quadrics(mesh, mesh.position, held_lines(mesh)), std::move(influences)) {}

bool RestPoseMetric::turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const {
  const auto& x = mesh.position;
  const auto corners = moved_corners(mesh, e);
  return std::any_of(corners.begin(), corners.end(), [&](const MovedCorner& c) {
    return turns_over(x[c.moved], to.position, x[c.a], x[c.b]);
  });
}

}  // namespace skinlod
