// SPDX-License-Identifier: MIT
#include "pipeline/metrics/rest_pose.h"

#include <algorithm>
#include <array>

#include "pipeline/influences.h"
#include "pipeline/metrics/surface_quadrics.h"

namespace skinlod {

RestPoseMetric::RestPoseMetric(const Mesh& mesh, std::vector<Influences> influences)
    : quadric_(surface_quadrics(mesh, mesh.position)), influences_(std::move(influences)) {}

RestPoseMetric::Placement RestPoseMetric::place(const Mesh& mesh, Edge e) const {
  const Vec3 &u = mesh.position[e.kept], &v = mesh.position[e.removed];
  const Quadric q = quadric_[e.kept] + quadric_[e.removed];

  const std::array<Vec3, 3> starts = {(u + v) / 2, u, v};
  const auto cheaper = [&](const Vec3& a, const Vec3& b) { return q(a) < q(b); };
  const Vec3 x = minimum(q, *std::min_element(starts.begin(), starts.end(), cheaper));
  const Vec3 along = v - u;
  const double length = along.squaredNorm();
  const double t = length > 0 ? std::clamp((x - u).dot(along) / length, 0.0, 1.0) : 0.5;
  return {std::max(0.0, q(x)), x, largest(blend(influences_[e.kept], influences_[e.removed], t), cap_)};
}

std::array<Placement, 3> RestPoseMetric::unsolved_places(const Mesh& mesh, Edge e) const {
  const Quadric q = quadric_[e.kept] + quadric_[e.removed];
  const auto at = [&](double t) {
    const Vec3 x = (1 - t) * mesh.position[e.kept] + t * mesh.position[e.removed];
    return Placement{std::max(0.0, q(x)), x,
                     largest(blend(influences_[e.kept], influences_[e.removed], t), cap_)};
  };
  return {at(0.5), at(0), at(1)};
}

bool RestPoseMetric::turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const {
  return skinlod::turns_a_face(mesh, e, to.position, [&](int v) -> const Vec3& { return mesh.position[v]; });
}

void RestPoseMetric::commit(Edge e, const Placement& to) {
  quadric_[e.kept] += quadric_[e.removed];
  influences_[e.kept] = to.influences;
}

History RestPoseMetric::limit_influences(const Mesh& mesh, int cap) {
  cap_ = cap;
  History history;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (!mesh.alive(v) || int(influences_[v].size()) <= cap) continue;
    influences_[v] = largest(influences_[v], cap);
    history.push_back({{v, -1}, 0, mesh.position[v], influences_[v]});
  }
  return history;
}

}  // namespace skinlod
