// SPDX-License-Identifier: MIT
#include "pipeline/metrics/posed_books.h"

#include <algorithm>

#include "pipeline/metrics/surface_quadrics.h"
#include "pipeline/parallel.h"

namespace skinlod {

PosedPoints::PosedPoints(const Mesh& mesh, std::span<const Influences> influences,
                         std::span<const Pose> poses) {
  for (const Pose& pose : poses) palettes_.push_back(pose.palette);
  posed_.resize(size_t(mesh.vertex_count()) * pose_count());
  parallel_for(mesh.vertex_count(), [&](int v) { move(v, mesh.position[v], influences[v]); });
}

void PosedPoints::move(int vertex, const Vec3& position, const Influences& influences) {
  for (size_t p = 0; p < pose_count(); ++p)
    posed_[vertex * pose_count() + p] = transform(blend(influences, palettes_[p]), position);
}

void PosedPoints::move(const History& steps) {
  for (const Step& step : steps) move(step.edge.kept, step.position, step.influences);
}

bool PosedPoints::turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const {
  const auto corners = moved_corners(mesh, e);
  for (size_t p = 0; p < pose_count(); ++p) {
    const Vec3 posed = transform(blend(to.influences, palettes_[p]), to.position);
    for (const auto& [moved, a, b] : corners) {
      if (turns_over(at(moved, p), posed, at(a, p), at(b, p))) return true;
    }
  }
  return false;
}

PosedQuadrics::PosedQuadrics(const Mesh& mesh, const PosedPoints& points)
    : poses_(points.pose_count()), quadric_(size_t(mesh.vertex_count()) * poses_) {
  const std::vector<HeldLine> lines = held_lines(mesh);
  std::vector<double> weights(poses_);
  parallel_for(int(poses_), [&](int p) {
    std::vector<Vec3> posed;
    for (int v = 0; v < mesh.vertex_count(); ++v) posed.push_back(points.at(v, size_t(p)));
    const auto quadrics = surface_quadrics(mesh, posed, lines);
    for (size_t v = 0; v < quadrics.size(); ++v) quadric_[v * poses_ + size_t(p)] = quadrics[v];
    for (const Quadric& q : quadrics) weights[size_t(p)] += q.A.trace();  // normals are of unit length
  });
  for (const double weight : weights) weight_ += weight;
}

PosedQuadrics::Along PosedQuadrics::along(Edge e, const PosedPoints& points) const {
  double kept = 0, removed = 0, middle = 0;
  for (size_t p = 0; p < poses_; ++p) {
    const Quadric both = of(e.kept)[p] + of(e.removed)[p];
    const Vec3 &a = points.at(e.kept, p), &b = points.at(e.removed, p);
    kept += both(a), removed += both(b), middle += both((a + b) / 2);
  }
  // A parabola goes through the three.
  const double bend = 2 * (kept + removed - 2 * middle), slope = 4 * middle - 3 * kept - removed;
  const double t = bend > 0 ? std::clamp(-slope / (2 * bend), 0.0, 1.0) : kept < removed ? 0 : 1;
  return {std::max(0.0, kept), std::max(0.0, removed), std::max(0.0, kept + t * (slope + t * bend))};
}

void PosedQuadrics::merge(Edge e) {
  for (size_t p = 0; p < poses_; ++p) quadric_[e.kept * poses_ + p] += of(e.removed)[p];
}

}  // namespace skinlod
