// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "pipeline/history.h"
#include "pipeline/quadric.h"

namespace skinlod {

/// How far the morph targets' offsets at a point are from those of the faces around it, as a function of
/// where the point is and of its offsets d_m:
///
///   F(x, d) = sum over the faces of area x sum over the targets m of |d_m - (G_m x + c_m)|^2
///
/// On every face what a target adds is linear in the point, so that this is Hoppe's quadric of an attribute
/// (attribute_quadrics.h) with three columns a target, whose unit is the metre already. The best offsets are
/// the mean of what the faces say, and what they leave is a quadric in x alone.
///
/// With target m on a surface is off by what it is off at rest and by this. The distance to the planes of the
/// moved faces would not see what slides along them: lips that part, corners of a mouth that smile.
class MorphQuadrics {
 public:
  explicit MorphQuadrics(const Mesh& mesh);

  /// How many targets there are.
  int count() const { return count_; }

  /// F of both ends together where the offsets are the best there are: m^4, summed over the targets.
  Quadric error(Edge e) const;

  /// Gives the placement the best offsets.
  void solve(Edge e, Placement& to) const;

  /// Gives it the blend of the ends' offsets. Returns how much more than `error` those cost.
  double blend(const Mesh& mesh, Edge e, Placement& to) const;

  /// True where carrying the collapse out turns a face over with some target on.
  bool turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const;

  /// From here on the kept end has the sum.
  void merge(Edge e);

 private:
  using Linear = Eigen::Matrix<double, 3, 4>;  // G x + c of a homogeneous point
  struct Entry {
    int morph;
    Linear linear;  // summed over the faces, times their areas
  };
  struct Sum {
    double area = 0;
    Quadric squares;             // of G x + c over all targets, times the areas
    std::vector<Entry> entries;  // by ascending morph: only those that move a face
    Sum& operator+=(const Sum& other);
  };
  static Sum of_triangle(const Mesh& mesh, const std::array<int, 3>& corners);
  static void for_each_entry(const Sum& a, const Sum& b, const auto& take);
  MorphOffsets best(Edge e, const Vec3& x) const;

  int count_ = 0;
  std::vector<Sum> sums_;  // per vertex; none where the mesh has no morphs
};

}  // namespace skinlod
