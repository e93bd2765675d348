// SPDX-License-Identifier: MIT
#include "pipeline/metrics/surface_quadrics.h"

#include <algorithm>
#include <array>

#include "pipeline/parallel.h"

namespace skinlod {

std::vector<HeldLine> held_lines(const Mesh& mesh, LineWeights weights) {
  const std::vector<Edge> edges = mesh.edges();
  std::vector<double> weight(edges.size());
  parallel_for(int(edges.size()), [&](int i) {
    const Edge e = edges[size_t(i)];
    weight[size_t(i)] = mesh.on_border(e) ? weights.border : mesh.on_seam(e) ? weights.seam : 0;
  });
  std::vector<HeldLine> lines;
  for (size_t i = 0; i < edges.size(); ++i) {
    const std::array ends = {edges[i].kept, edges[i].removed};
    if (weight[i] > 0)
      lines.push_back({edges[i], weight[i] * mesh.error_weight(ends), mesh.faces_of(edges[i])});
  }
  return lines;
}

std::vector<Quadric> surface_quadrics(const Mesh& mesh, std::span<const Vec3> points,
                                      std::span<const HeldLine> lines) {
  std::vector<Quadric> quadrics(mesh.position.size());
  const auto normal_of = [&](std::span<const int> face) {
    const Vec3& a = points[face[0]];
    const Vec3& b = points[face[1]];
    const Vec3& c = points[face[2]];
    return Vec3(face.size() == 4 ? (c - a).cross(points[face[3]] - b) : (b - a).cross(c - a));
  };
  for (int f = 0; f < mesh.face_slots(); ++f) {
    const auto face = mesh.face(f);
    if (face.empty()) continue;
    const Vec3 n = normal_of(face);
    const double size = n.norm();
    if (!(size > 0)) continue;
    const Quadric q = plane_quadric(points[face[0]], n / size, mesh.error_weight(face) * size / 2);
    for (const int v : face) quadrics[v] += q;
  }
  for (const auto& [e, weight, faces] : lines) {
    const Vec3 along = points[e.removed] - points[e.kept];
    for (const int f : faces) {
      const Vec3 across = along.cross(normal_of(mesh.face(f)));
      const double size = across.norm();
      if (!(size > 0)) continue;
      const Quadric q = plane_quadric(points[e.kept], across / size, weight * along.squaredNorm());
      quadrics[e.kept] += q, quadrics[e.removed] += q;
    }
  }
  return quadrics;
}

ShortList<MovedCorner, 16> moved_corners(const Mesh& mesh, Edge edge) {
  ShortList<MovedCorner, 16> corners;
  for (const Edge e : {edge, edge.turned()}) {
    const int end = e.kept, other = e.removed;
    for (const int f : mesh.faces_around(end)) {
      const auto face = mesh.face(f);
      const size_t n = face.size();
      const bool both = std::find(face.begin(), face.end(), other) != face.end();
      if (both && (n == 3 || end == edge.removed)) continue;
      const size_t i = size_t(std::find(face.begin(), face.end(), end) - face.begin());
      int a = face[(i + 1) % n], b = face[(i + n - 1) % n];
      // Where a quad loses the other end, the next one is taken.
      if (a == other) a = face[(i + 2) % n];
      if (b == other) b = face[(i + n - 2) % n];
      corners.push_back({end, a, b});
    }
  }
  return corners;
}

}  // namespace skinlod
