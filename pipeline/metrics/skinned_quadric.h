// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/influences.h"
#include "pipeline/pose.h"
#include "pipeline/quadric.h"

namespace skinlod {

/// At most so many joints take part in one solve: the largest influences of a vertex beyond it are dropped.
inline constexpr int kMaxJoints = 64;

/// One weight per joint of a SkinnedQuadric.
using Weights = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;

/// The error of one point under linear blend skinning, as a function of its rest position and its weights:
/// E(x, w) = sum_p q_p( sum_b w_b T_b^p x ), over the joints b of `joints` (Landreneau & Schaefer 2009, eq.
/// 3). Quadratic in x while w is held and in w while x is held; never negative where the q_p are sums of
/// squares.
///
/// The poses are added up once: with z the weights times [x; 1], weight by weight, E = z'Sz + 2g'z + c, and
/// no step that follows knows how many poses there were.
class SkinnedQuadric {
 public:
  /// One quadric and one palette per pose. Nothing is lost to rounding for points not far from `near`, in
  /// rest space.
  SkinnedQuadric(std::span<const Quadric> per_pose, std::span<const Palette> palettes,
                 std::vector<int> joints, const Vec3& near = Vec3::Zero());

  /// The same without a pose yet: 0 everywhere. Poses are added one by one.
  SkinnedQuadric(std::vector<int> joints, const Vec3& near);
  void add(const Quadric& q, const Palette& palette);

  double operator()(const Vec3& x, const Weights& w) const;

  /// The position that minimises E under weights `w`, closest to `near` (section 3.1).
  Vec3 best_position(const Weights& w, const Vec3& near) const;

  /// The weights with sum 1 that minimise E at `x` under `rule`, by the smallest offset from `start`, which
  /// must be such weights itself (section 3.2; w >= 0 by an active set).
  Weights best_weights(const Vec3& x, const Weights& start, WeightRule rule = WeightRule::NonNegative) const;

  /// The same problem over some of the joints, by their places in `joints()`.
  SkinnedQuadric over(std::span<const int> places) const;

  const std::vector<int>& joints() const { return joints_; }

 private:
  size_t rows() const { return 4 * joints_.size(); }
  Quadric at(const Weights& w) const;
  template <int K>
  void add_pose(const Quadric& q, const Vec3& middle, const double* B);

  std::vector<int> joints_;
  Vec3 origin_;            // where x is measured from
  std::vector<double> S_;  // rows() x rows(), four per joint; of the blocks below the diagonal none is set
  std::vector<double> g_;
  double c_ = 0;
  double size_ = 0;       // what E would be as far off as the posed points are from the world's origin
  double curvature_ = 0;  // of all poses, in all directions
  double spread_ = 0;     // and of the joints' points from their middle, if no plane lay along the way
};

}  // namespace skinlod
