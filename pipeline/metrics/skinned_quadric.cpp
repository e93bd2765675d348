// SPDX-License-Identifier: MIT
#include "pipeline/metrics/skinned_quadric.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace skinlod {
namespace {

using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, kMaxJoints>;
using Points = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxJoints>;

// The ridge that picks the smallest offset among weights that fit alike, as a share of the mean curvature.
constexpr double kWeightRidge = 1e-6;

// Joints whose points differ by less than the root of this, relative to where they are, move alike: what
// their weights could change is rounding.
constexpr double kAlike = 1e-18;

// The step s that minimises s'Hs/2 + r's with sum 0, over the places in `free`; 0 elsewhere.
Weights constrained_step(const SmallMatrix& H, const Weights& r, const std::vector<int>& free) {
  const auto n = Eigen::Index(free.size());
  SmallMatrix A(n, n);
  Weights rhs(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    rhs[i] = -r[free[i]];
    for (Eigen::Index j = 0; j < n; ++j) A(i, j) = H(free[i], free[j]);
  }
  const Eigen::LLT<SmallMatrix> factor(A);
  const Weights unconstrained = factor.solve(rhs), ones = factor.solve(Weights::Ones(n));
  const Weights step = unconstrained - unconstrained.sum() / ones.sum() * ones;
  Weights s = Weights::Zero(H.rows());
  for (Eigen::Index i = 0; i < n; ++i) s[free[i]] = step[i];
  return s;
}

}  // namespace

SkinnedQuadric::SkinnedQuadric(std::vector<Quadric> per_pose, std::span<const Palette> palettes,
                               std::vector<int> joints)
    : per_pose_(std::move(per_pose)), palettes_(palettes), joints_(std::move(joints)) {}

Affine SkinnedQuadric::blended(size_t p, const Weights& w) const {
  Affine sum = w[0] * palettes_[p][joints_[0]];
  for (size_t k = 1; k < joints_.size(); ++k) {
    if (w[Eigen::Index(k)] != 0) sum += w[Eigen::Index(k)] * palettes_[p][joints_[k]];
  }
  return sum;
}

double SkinnedQuadric::operator()(const Vec3& x, const Weights& w) const {
  double error = 0;
  for (size_t p = 0; p < per_pose_.size(); ++p) error += per_pose_[p](transform(blended(p, w), x));
  return std::max(0.0, error);
}

Vec3 SkinnedQuadric::best_position(const Weights& w, const Vec3& near) const {
  Quadric rest;
  for (size_t p = 0; p < per_pose_.size(); ++p) rest += pulled_back(per_pose_[p], blended(p, w));
  return minimum(rest, near);
}

// In the offset d from the start E is d'Hd + 2 r'd + E(start); with sum d = 0 only the differences between
// the joints' points matter, so H is built about the posed point, where it loses the least to rounding.
Weights SkinnedQuadric::best_weights(const Vec3& x, const Weights& start, WeightRule rule) const {
  const auto K = Eigen::Index(joints_.size());
  if (K == 1) return start;
  SmallMatrix H = SmallMatrix::Zero(K, K);
  Weights r = Weights::Zero(K);
  Points Y(3, K), Ay(3, K);
  double scale = 0;
  for (size_t p = 0; p < per_pose_.size(); ++p) {
    const Quadric& q = per_pose_[p];
    for (Eigen::Index k = 0; k < K; ++k) Y.col(k) = transform(palettes_[p][joints_[k]], x);
    const Vec3 y = Y * start;
    scale += q.A.trace() * y.squaredNorm();
    Y.colwise() -= y;
    for (Eigen::Index k = 0; k < K; ++k) Ay.col(k) = q.A * Y.col(k);
    const Vec3 slope = q.A * y + q.b;
    for (Eigen::Index k = 0; k < K; ++k) {
      r[k] += slope.dot(Y.col(k));
      for (Eigen::Index l = 0; l <= k; ++l) H(k, l) += Y.col(k).dot(Ay.col(l));
    }
  }
  for (Eigen::Index k = 0; k < K; ++k) {
    for (Eigen::Index l = 0; l < k; ++l) H(l, k) = H(k, l);
  }
  const double curvature = H.trace() / double(K);
  if (!(curvature > kAlike * scale)) return start;
  H.diagonal().array() += kWeightRidge * curvature;

  std::vector<int> free;
  for (int k = 0; k < K; ++k) free.push_back(k);
  if (rule == WeightRule::Signed) return start + constrained_step(H, r, free);

  // Primal active set: walk to the minimum over the free weights, stop where one reaches zero and hold it
  // there; when no step is left, free the weight that would lower E the most, if any.
  Weights w = start;
  for (int turn = 0; turn < 4 * int(K); ++turn) {
    const Weights slope = r + H * (w - start);
    const Weights s = constrained_step(H, slope, free);
    double reach = 1;
    int blocking = -1;
    for (const int k : free) {
      if (s[k] < 0 && w[k] < -s[k] * reach) reach = w[k] / -s[k], blocking = k;
    }
    w += reach * s;
    if (blocking >= 0) {
      w[blocking] = 0;
      std::erase(free, blocking);
      continue;
    }
    const Weights at = r + H * (w - start);
    const double level = at[free.front()];
    int worst = -1;
    for (int k = 0; k < K; ++k) {
      const bool held = std::find(free.begin(), free.end(), k) == free.end();
      if (held && at[k] < level - 1e-9 * curvature && (worst < 0 || at[k] < at[worst])) worst = k;
    }
    if (worst < 0) break;
    free.insert(std::upper_bound(free.begin(), free.end(), worst), worst);
  }
  w = w.cwiseMax(0.0);
  return w / w.sum();
}

SkinnedQuadric SkinnedQuadric::over(std::span<const int> places) const {
  std::vector<int> joints;
  for (const int place : places) joints.push_back(joints_[place]);
  return {per_pose_, palettes_, std::move(joints)};
}

}  // namespace skinlod
