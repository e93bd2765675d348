// SPDX-License-Identifier: MIT
#include "pipeline/metrics/rest_pose.h"

#include "pipeline/metrics/surface_quadrics.h"

namespace skinlod {

RestPoseMetric::RestPoseMetric(const Mesh& mesh, std::vector<Influences> influences)
    : quadrics_(surface_quadrics(mesh, mesh.position, held_lines(mesh)), std::move(influences)) {}

bool RestPoseMetric::turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const {
  return skinlod::turns_a_face(mesh, e, to.position, [&](int v) -> const Vec3& { return mesh.position[v]; });
}

}  // namespace skinlod
