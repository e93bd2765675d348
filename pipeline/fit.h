// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "pipeline/linalg.h"

namespace skinlod {

/// Rows of up to three unknowns at the corners of triangles, found by least squares from what they should
/// come to at places in between.
class Fit {
 public:
  using Row = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, 3>;
  using Corners = std::array<int, 3>;

  /// What each row is so far, and holds on to a little; and per triangle the rows at its corners, of which -1
  /// is one of zeros that stays.
  Fit(Rows start, std::vector<Corners> triangles);

  /// The rows of a triangle, interpolated by `share`, should be `target`.
  void add(int triangle, const Vec3& share, double weight, const Row& target);

  Rows solve() const;

 private:
  Rows start_, pulled_;
  std::vector<Corners> triangles_;
  std::vector<Mat3> curvature_;  // per triangle
};

}  // namespace skinlod
