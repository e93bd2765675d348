// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/character.h"
#include "pipeline/quadric.h"

namespace skinlod {

/// What is linear on a triangle: a value at x is g.x + d, with g in its plane.
class LinearOnTriangle {
 public:
  /// A corner a column.
  explicit LinearOnTriangle(const Mat3& corners);

  double area() const { return area_; }

  /// (g, d) from the values at the corners; not for a triangle without area.
  Vec4 operator()(const Vec3& values) const;

 private:
  Vec3 u_, v_, middle_;
  double area_, uu_, vv_, uv_;
};

/// How far the attributes at a point are from those of the faces around it, as a function of where the point
/// is: Hoppe 1999, "New Quadric Metric for Simplifying Meshes with Appearance Attributes", section 4. On
/// every face an attribute is a linear function g.x + d of the position; a value a at x is off by the sum
/// over the faces of area x (a - g.x - d)^2, and the least of that over a is a quadric in x alone.
///
/// Attributes belong to *groups* of wedges, which share their values. Sums over groups are exact: a group
/// that stands for many is as off from all their faces as its value makes it.
class AttributeQuadrics {
 public:
  /// What one of a column is worth: a metre, or the size of the patch of surface that the group stands for,
  /// the root of its area. So a bend of the normals weighs as much as the distance that goes with it on a
  /// patch of that size, in fine levels and in coarse.
  enum class Unit { Metre, PatchSize };

  AttributeQuadrics() = default;
  AttributeQuadrics(int groups, int columns, Unit unit);

  /// A triangle at `x`, a corner a column, with a row of attributes a corner, and the corners' groups. Its
  /// area counts `weight` times.
  void add_face(const Mat3& x, const Rows& attributes, std::span<const int> groups, double weight = 1);

  /// From here on `kept` has what both have.
  void merge(int kept, int removed);

  /// Of the triangles that a group stands for, each as often as it has corners in the group, and as it counts
  /// there: m^2.
  double weight(int group) const { return of(group)[kWeight]; }

  /// The error where `groups` share the values that are best for all of them: m^4, as of positions.
  Quadric error(std::span<const int> groups) const;

 private:
  // Sums in one run per group, which is one stretch of memory: the area as it is, and as it counts; of the
  // latter x (g.x + d)^2 over all columns, a quadric; and column by column of the latter x (g, d).
  static constexpr size_t kArea = 0, kWeight = 1, kSquares = 2, kLinear = 15;
  size_t run() const { return kLinear + 4 * columns_; }
  const double* of(int group) const { return sums_.data() + size_t(group) * run(); }
  double* of(int group) { return sums_.data() + size_t(group) * run(); }

  size_t columns_ = 0;
  Unit unit_ = Unit::Metre;
  std::vector<double> sums_;  // [group][run()]
};

/// Normals and colours, a group for each wedge.
AttributeQuadrics shading_quadrics(const Surface& surface);

/// Uvs, in metres by how large the texture lies on the surface. `sheet` has the group of each wedge.
AttributeQuadrics texture_quadrics(const Surface& surface, std::span<const int> sheet);

}  // namespace skinlod
