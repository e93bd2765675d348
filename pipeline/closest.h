// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "pipeline/character.h"

namespace skinlod {

/// A point of a surface of triangles that goes with its face into every pose.
struct Place {
  int face;
  Vec3 share;  // barycentric
};

/// The point of triangle abc closest to `x`, as shares of its corners (Ericson, Real-Time Collision
/// Detection, 5.1.5). A triangle without area is its longest edge, or its point.
Vec3 closest_shares(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c);

/// The closest point of a surface: in the lowest of the faces that are equally close.
struct ClosestPoint {
  double squared = 0;  // distance, m^2
  int face = -1;
  Vec3 share = Vec3::Zero();  // barycentric
};

/// The faces of a surface in nested boxes, four in each, by where they lie at rest. One tree serves all
/// poses: what lies together at rest does so in most.
class FaceTree {
 public:
  /// `surface` must outlive this, must have a face, and all its faces must be triangles.
  explicit FaceTree(const Surface& surface);

  const Surface& surface() const { return surface_; }

  /// The vertices of each face.
  std::span<const std::array<int, 3>> faces() const { return vertices_; }

  /// What is in a box: boxes of higher indices, ~f for face f, or nothing.
  using Four = std::array<int, 4>;
  static constexpr int kEmpty = 0;

  /// The first holds all.
  std::span<const Four> boxes() const { return boxes_; }

 private:
  void divide(int box, std::span<int> faces, std::span<const Vec3> middle);

  const Surface& surface_;
  std::vector<std::array<int, 3>> vertices_;  // per face
  std::vector<Four> boxes_;
};

/// Four floats side by side. Compilers make one instruction of four where they are told to.
using FourFloats = float __attribute__((vector_size(16)));
inline FourFloats floats(const Vec3& x) { return FourFloats{float(x[0]), float(x[1]), float(x[2]), 0}; }

/// A surface of triangles in one pose that can be asked for its closest point. The boxes around its faces are
/// floats and only narrow the search; distances are doubles, and the search radius has room for the rounding,
/// so that no answer depends on the boxes.
class PosedSurface {
 public:
  /// `surface` must be as for a tree; `points` has a place for each vertex.
  PosedSurface(const Surface& surface, std::vector<Vec3> points);

  /// One pose of many: the tree is made once for all.
  PosedSurface(std::shared_ptr<const FaceTree> tree, std::vector<Vec3> points);

  /// `guess` is a face that may be near; it changes the time alone.
  ClosestPoint closest(const Vec3& x, int guess = 0) const;

  /// The same among the faces whose normals are within a right angle of `direction`; no face where there is
  /// none.
  ClosestPoint closest_facing(const Vec3& x, const Vec3& direction, int guess = 0) const;

  const Surface& surface() const { return tree_->surface(); }

  /// The corners of face `f`.
  std::array<Vec3, 3> triangle(int f) const {
    const auto& [a, b, c] = tree_->faces()[f];
    return {points_[a], points_[b], points_[c]};
  }
  Vec3 at(int f, const Vec3& share) const {
    const auto& [a, b, c] = tree_->faces()[f];
    return share[0] * points_[a] + share[1] * points_[b] + share[2] * points_[c];
  }

  /// Twice the area of face `f`, along its normal.
  Vec3 normal(int f) const {
    const auto& [a, b, c] = tree_->faces()[f];
    return (points_[b] - points_[a]).cross(points_[c] - points_[a]);
  }

  /// The squared distance from `x` to face `f`.
  double squared_distance(const Vec3& x, int f) const;

  /// The diagonal of the box around it, metres.
  double size() const { return size_; }

 private:
  // The four boxes in one of the tree's, about `centre_`, side by side.
  struct Boxes {
    std::array<FourFloats, 3> low, high;
    FaceTree::Four in;
  };
  void fit_boxes();
  void consider(const Vec3& x, int f, ClosestPoint& best) const;
  template <class Counts>
  ClosestPoint closest_of(const Vec3& x, int guess, const Counts& counts) const;

  std::shared_ptr<const FaceTree> tree_;
  std::vector<Vec3> points_;
  std::vector<Boxes> boxes_;
  Vec3 centre_;
  double size_;
};

}  // namespace skinlod
