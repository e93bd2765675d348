// SPDX-License-Identifier: MIT
#include "pipeline/metrics/rest_quadrics.h"

#include <algorithm>

#include "pipeline/influences.h"
#include "pipeline/metrics/limit_influences.h"

namespace skinlod {

RestQuadrics::RestQuadrics(std::vector<Quadric> quadric, std::vector<Influences> influences)
    : quadric_(std::move(quadric)), influences_(std::move(influences)) {}

Placement RestQuadrics::at(const Quadric& q, const Vec3& x, Edge e, double t) const {
  return {std::max(0.0, q(x)), x, largest(blend(influences_[e.kept], influences_[e.removed], t), cap_)};
}

Vec3 RestQuadrics::best_point(const Mesh& mesh, Edge e, const Quadric& q) const {
  const Vec3 &u = mesh.position[e.kept], &v = mesh.position[e.removed];
  const std::array<Vec3, 3> starts = {(u + v) / 2, u, v};
  const std::array<double, 3> costs = {q(starts[0]), q(u), q(v)};
  return minimum(q, starts[size_t(std::min_element(costs.begin(), costs.end()) - costs.begin())]);
}

double RestQuadrics::estimate(const Mesh& mesh, Edge e) const {
  const Quadric q = quadric_[e.kept] + quadric_[e.removed];
  return std::max(0.0, q(best_point(mesh, e, q)));
}

Placement RestQuadrics::place(const Mesh& mesh, Edge e) const {
  const Vec3 &u = mesh.position[e.kept], &v = mesh.position[e.removed];
  const Quadric q = quadric_[e.kept] + quadric_[e.removed];
  const Vec3 x = best_point(mesh, e, q);
  const Vec3 along = v - u;
  const double length = along.squaredNorm();
  const double t = length > 0 ? std::clamp((x - u).dot(along) / length, 0.0, 1.0) : 0.5;
  return at(q, x, e, t);
}

std::array<Placement, 3> RestQuadrics::unsolved_places(const Mesh& mesh, Edge e) const {
  const Quadric q = quadric_[e.kept] + quadric_[e.removed];
  const auto along = [&](double t) {
    return at(q, (1 - t) * mesh.position[e.kept] + t * mesh.position[e.removed], e, t);
  };
  return {along(0.5), along(0), along(1)};
}

void RestQuadrics::commit(Edge e, const Placement& to) {
  quadric_[e.kept] += quadric_[e.removed];
  influences_[e.kept] = to.influences;
}

History RestQuadrics::limit_influences(const Mesh& mesh, int cap) {
  cap_ = cap;
  return skinlod::limit_influences(mesh, influences_, cap);
}

}  // namespace skinlod
