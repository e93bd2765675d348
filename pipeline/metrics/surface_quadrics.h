// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/mesh.h"
#include "pipeline/quadric.h"

namespace skinlod {

/// How strongly borders and seams hold, against the faces.
struct LineWeights {
  double border = 1;
  double seam = 0.1;
};

/// An edge that has planes of its own, how much they weigh against faces, and the faces that have the edge.
struct HeldLine {
  Edge edge;
  double weight;
  Mesh::Few faces;
};

/// The borders and seams of the mesh: the same wherever its points stand.
std::vector<HeldLine> held_lines(const Mesh& mesh, LineWeights weights = {});

/// One quadric per vertex for the mesh standing at `points`: for each face around it, area x squared distance
/// to the face's plane (Garland & Heckbert 1997, section 5); for each border edge, weight x squared length x
/// squared distance to the plane through the edge square to its face (their section 6), and the same for
/// each seam edge with its own weight, so that texture charts keep their outline.
std::vector<Quadric> surface_quadrics(const Mesh& mesh, std::span<const Vec3> points,
                                      std::span<const HeldLine> lines);

/// True where moving the edge's ends to `to` turns a surviving face around them by a right angle or more, or
/// flattens it to nothing, with the vertices standing at `point(v)`.
template <class PointOf>
bool turns_a_face(const Mesh& mesh, Edge edge, const Vec3& to, const PointOf& point) {
  // Below this share of its longest edges' product a face's area is rounding noise.
  constexpr double kFlat = 1e-12;
  for (const int end : {edge.kept, edge.removed}) {
    const int other = end == edge.kept ? edge.removed : edge.kept;
    for (const int f : mesh.faces_around(end)) {
      const auto face = mesh.face(f);
      const size_t n = face.size();
      const bool both = std::find(face.begin(), face.end(), other) != face.end();
      if (both && (n == 3 || end == edge.removed)) continue;
      const size_t i = size_t(std::find(face.begin(), face.end(), end) - face.begin());
      // The corner's triangle stands for the face; where a quad loses the other end, the next one is taken.
      int a = face[(i + 1) % n], b = face[(i + n - 1) % n];
      if (a == other) a = face[(i + 2) % n];
      if (b == other) b = face[(i + n - 2) % n];
      const Vec3 xa = point(a), xb = point(b), x = point(end);
      const Vec3 before = (xa - x).cross(xb - x), after = (xa - to).cross(xb - to);
      const double size = (xa - to).squaredNorm() * (xb - to).squaredNorm();
      if (before.squaredNorm() == 0) continue;
      if (before.dot(after) <= 0 || after.squaredNorm() <= kFlat * size) return true;
    }
  }
  return false;
}

}  // namespace skinlod
