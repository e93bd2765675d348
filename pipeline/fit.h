// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "pipeline/linalg.h"

namespace skinlod {

/// Rows of unknowns at the corners of triangles, found by least squares from what they should come to at
/// places in between.
class Fit {
 public:
  using Row = Eigen::RowVectorXd;

  /// What each row is so far, and holds on to a little.
  explicit Fit(Rows start);

  /// The rows of a triangle's `corners`, interpolated by `share`, should be `target`; -1 is a row of zeros
  /// that stays.
  void add(const std::array<int, 3>& corners, const Vec3& share, double weight, const Row& target);

  Rows solve() const;

 private:
  Rows start_, pulled_;
  std::vector<Eigen::Triplet<double>> entries_;
};

}  // namespace skinlod
