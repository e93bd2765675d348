// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pipeline/closest.h"

namespace skinlod {

/// A place on an original, and one on its level of detail: one of them given, the other the closest to it.
struct Pair {
  Place original, level;
  bool given_on_level;
  double area;  // that the given place stands for, as a share of its surface's, and as it counts there
};

/// The connectivity of a surface of triangles, for walks over it in any pose.
class Neighbourhood {
 public:
  explicit Neighbourhood(const Surface& surface);

  int face_count() const { return int(vertices_.size()); }
  int vertex_count() const { return int(begin_.size()) - 1; }
  const std::array<int, 3>& vertices(int face) const { return vertices_[face]; }
  std::span<const int> faces_around(int vertex) const {
    return {around_.data() + begin_[vertex], size_t(begin_[vertex + 1] - begin_[vertex])};
  }

  /// Where a place is, and a face's vector area, while the vertices stand at `points`.
  Vec3 at(std::span<const Vec3> points, const Place& place) const;
  Vec3 vector_area(std::span<const Vec3> points, int face) const;

  /// The place that a walk from `face` comes to, from neighbour to closer neighbour: the closest to `x` but
  /// where the surface in between leads away from it.
  Place closest(std::span<const Vec3> points, const Vec3& x, int face) const;

 private:
  std::vector<std::array<int, 3>> vertices_;
  std::vector<int> begin_, around_;  // the faces around vertex v are around_[begin_[v]] and on
};

/// Whether faces of these vector areas may be sides of one surface: the back of a thin one is not. Faces that
/// meet in a sharp edge are, since a place on the edge is on both.
inline bool look_alike(const Vec3& a, const Vec3& b) { return a.dot(b) > -0.5 * a.norm() * b.norm(); }

/// Pairs given from both sides, at rest: the corners, the middles of the edges and the middle of every face
/// of the original; and of each of the triangles that `level`'s faces are cut into, n x n each, n = 2 unless
/// there are many. They are weighted so that cubics are integrated exactly, and as the original's importance
/// says. A place and a closest face that do not look alike are no pair.
std::vector<Pair> paired(const Surface& original, const Surface& level);

}  // namespace skinlod
