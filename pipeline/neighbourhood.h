// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pipeline/closest.h"

namespace skinlod {

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
  Vec3 at(std::span<const Vec3> points, const Place& place) const {
    const auto& [a, b, c] = vertices_[place.face];
    return place.share[0] * points[a] + place.share[1] * points[b] + place.share[2] * points[c];
  }
  Vec3 vector_area(std::span<const Vec3> points, int face) const {
    const auto& [a, b, c] = vertices_[face];
    return (points[b] - points[a]).cross(points[c] - points[a]) / 2;
  }

  /// The place that a walk from `face` comes to, from neighbour to closer neighbour: the closest to `x` but
  /// where the surface in between leads away from it.
  Place closest(std::span<const Vec3> points, const Vec3& x, int face) const;

 private:
  std::vector<std::array<int, 3>> vertices_;
  std::vector<int> begin_, around_;  // the faces around vertex v are around_[begin_[v]] and on
};

}  // namespace skinlod
