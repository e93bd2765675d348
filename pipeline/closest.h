// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "pipeline/character.h"

namespace skinlod {

/// The point of triangle abc closest to `x`, as shares of its corners (Ericson, Real-Time Collision
/// Detection, 5.1.5). A triangle without area is its longest edge, or its point.
Vec3 closest_shares(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c);

/// The closest point of a surface: in the lowest of the faces that are equally close.
struct ClosestPoint {
  double squared = 0;  // distance, m^2
  int face = -1;
  Vec3 share = Vec3::Zero();  // barycentric
};

/// A surface of triangles in one pose that can be asked for its closest point. Embree holds floats and only
/// narrows the search; distances are ours, in double, and the search radius has room for the rounding, so
/// that no answer depends on the CPU's instructions.
class PosedSurface {
 public:
  /// `surface` must outlive this, must have a face, and all its faces must be triangles; `points` has a place
  /// for each vertex.
  PosedSurface(const Surface& surface, std::vector<Vec3> points);

  /// `guess` is a face that may be near; it changes the time alone.
  ClosestPoint closest(const Vec3& x, int guess = 0) const;

  const Surface& surface() const { return surface_; }
  const Vec3& point(int v) const { return points_[v]; }
  std::array<int, 3> vertices(int f) const { return triangle_vertices(surface_, f); }

  /// The corners of face `f`.
  const std::array<Vec3, 3>& triangle(int f) const { return triangles_[f]; }
  Vec3 at(int f, const Vec3& share) const {
    const auto& [a, b, c] = triangles_[f];
    return share[0] * a + share[1] * b + share[2] * c;
  }

  /// The squared distance from `x` to face `f`.
  double squared_distance(const Vec3& x, int f) const;

  /// The diagonal of the box around it, metres.
  double size() const { return size_; }

 private:
  struct Search;
  struct Release {
    void operator()(void* scene) const;
  };
  void consider(Search& search, int f) const;

  const Surface& surface_;
  std::vector<Vec3> points_;
  std::vector<std::array<Vec3, 3>> triangles_;  // per face, its points: what every question goes through
  Vec3 centre_;
  double size_;
  std::unique_ptr<void, Release> scene_;
};

}  // namespace skinlod
