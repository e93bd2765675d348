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
  double seam = 0.3;  // with 0.1 uvs are 3 % worse, with 1 positions
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
/// each seam edge with its own weight, so that texture charts keep their outline. All count as the importance
/// of their vertices says.
std::vector<Quadric> surface_quadrics(const Mesh& mesh, std::span<const Vec3> points,
                                      std::span<const HeldLine> lines);

/// A triangle that stays when an edge is collapsed, with the corner that moves; the corner's triangle stands
/// for a quad.
struct MovedCorner {
  int moved, a, b;
};

/// The corners at either end of the edge, in the faces that a collapse leaves.
ShortList<MovedCorner, 16> moved_corners(const Mesh& mesh, Edge edge);

/// True where the triangle (x, a, b) is turned by a right angle or more, or flattened to nothing, when its
/// first corner moves to `to`. One without area has no side to turn from.
inline bool turns_over(const Vec3& x, const Vec3& to, const Vec3& a, const Vec3& b) {
  // Below this share of its longest edges' product a face's area is rounding noise.
  constexpr double kFlat = 1e-12;
  const Vec3 before = (a - x).cross(b - x), after = (a - to).cross(b - to);
  if (before.dot(after) <= 0) return before.squaredNorm() != 0;
  return after.squaredNorm() <= kFlat * ((a - to).squaredNorm() * (b - to).squaredNorm());
}

}  // namespace skinlod
