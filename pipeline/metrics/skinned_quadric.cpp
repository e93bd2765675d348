// SPDX-License-Identifier: MIT
#include "pipeline/metrics/skinned_quadric.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace skinlod {
namespace {

using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, kMaxJoints>;

// The ridge that picks the smallest offset among weights that fit alike, as a share of the mean curvature.
constexpr double kWeightRidge = 1e-6;

// Joints whose points differ by less than the root of this, relative to where they are, move alike: what
// their weights could change is rounding. The first against the world's origin, the second against ours.
constexpr double kAlike = 1e-18, kAlikeNear = 1e-13;

// What H is summed up from, relative to what it comes to: below this share it is rounding.
constexpr double kRounding = 1e-14;

// Solves Ax = b for a positive definite matrix in place, by its lower half. A pivot below `least` is
// rounding.
struct Cholesky {
  Cholesky(SmallMatrix& A, double least) : L(A), n(A.rows()) {
    for (Eigen::Index j = 0; j < n; ++j) {
      for (Eigen::Index k = 0; k < j; ++k) {
        for (Eigen::Index i = j; i < n; ++i) L(i, j) -= L(i, k) * L(j, k);
      }
      L(j, j) = std::sqrt(std::max(L(j, j), least));
      for (Eigen::Index i = j + 1; i < n; ++i) L(i, j) /= L(j, j);
    }
  }
  void solve(Weights& b) const {
    for (Eigen::Index j = 0; j < n; ++j) {
      b[j] /= L(j, j);
      for (Eigen::Index i = j + 1; i < n; ++i) b[i] -= L(i, j) * b[j];
    }
    for (Eigen::Index j = n - 1; j >= 0; --j) {
      for (Eigen::Index i = j + 1; i < n; ++i) b[j] -= L(i, j) * b[i];
      b[j] /= L(j, j);
    }
  }
  SmallMatrix& L;
  Eigen::Index n;
};

// The step s that minimises s'Hs/2 + r's with sum 0, over the places in `free`; 0 elsewhere. H has `ridge` on
// its diagonal.
Weights constrained_step(const SmallMatrix& H, const Weights& r, const std::vector<int>& free, double ridge) {
  const auto n = Eigen::Index(free.size());
  SmallMatrix A(n, n);
  Weights step = Weights::Zero(n), ones = Weights::Ones(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    step[i] = -r[free[i]];
    for (Eigen::Index j = 0; j <= i; ++j) A(i, j) = H(free[i], free[j]);
  }
  const Cholesky factor(A, ridge);
  factor.solve(step), factor.solve(ones);
  double sum = 0, count = 0;
  for (Eigen::Index i = 0; i < n; ++i) sum += step[i], count += ones[i];
  const double shift = sum / count;
  Weights s = Weights::Zero(H.rows());
  for (Eigen::Index i = 0; i < n; ++i) s[free[i]] = step[i] - shift * ones[i];
  return s;
}

}  // namespace

// S += B'AB and g += B'(A middle + b). Most edges follow few joints: with their number known when this is
// compiled it takes half as long.
template <int K>
void SkinnedQuadric::add_pose(const Quadric& q, const Vec3& middle, const double* B) {
  const size_t n = K > 0 ? 4 * K : rows();
  std::array<double, 12 * (K > 0 ? K : kMaxJoints)> AB;
  const Vec3 slope = q.A * middle + q.b;
  for (size_t j = 0; j < n; ++j) {
    const double x = B[j], y = B[n + j], z = B[2 * n + j];
    for (int i = 0; i < 3; ++i) AB[i * n + j] = q.A(i, 0) * x + q.A(i, 1) * y + q.A(i, 2) * z;
    g_[j] += slope[0] * x + slope[1] * y + slope[2] * z;
  }
  for (size_t i = 0; i < n; ++i) {
    double* const row = &S_[i * n];
    const double x = AB[i], y = AB[n + i], z = AB[2 * n + i];
    for (size_t j = i & ~size_t(3); j < n; ++j) row[j] += x * B[j] + y * B[n + j] + z * B[2 * n + j];
  }
}

SkinnedQuadric::SkinnedQuadric(std::vector<int> joints, const Vec3& near)
    : joints_(std::move(joints)), origin_(near), S_(rows() * rows()), g_(rows()) {}

SkinnedQuadric::SkinnedQuadric(std::span<const Quadric> per_pose, std::span<const Palette> palettes,
                               std::vector<int> joints, const Vec3& near)
    : SkinnedQuadric(std::move(joints), near) {
  for (size_t p = 0; p < per_pose.size(); ++p) add(per_pose[p], palettes[p]);
}

// Everything is measured from points in the middle of things, in rest space and in each pose: sums of squares
// about a far origin would cancel.
void SkinnedQuadric::add(const Quadric& q, const Palette& palette) {
  const size_t n = rows();
  constexpr std::array kAdd = {&SkinnedQuadric::add_pose<0>, &SkinnedQuadric::add_pose<1>,
                               &SkinnedQuadric::add_pose<2>, &SkinnedQuadric::add_pose<3>,
                               &SkinnedQuadric::add_pose<4>, &SkinnedQuadric::add_pose<5>,
                               &SkinnedQuadric::add_pose<6>};
  std::array<double, 12 * kMaxJoints> B;  // 3 x n, row by row: the posed point is B z
  Vec3 middle = Vec3::Zero();
  for (size_t k = 0; k < joints_.size(); ++k) {
    const Affine& T = palette[joints_[k]];
    const Vec3 posed = transform(T, origin_);
    middle += posed;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) B[i * n + 4 * k + j] = T(i, j);
      B[i * n + 4 * k + 3] = posed[i];
    }
  }
  middle /= double(joints_.size());
  double apart = 0;
  for (size_t k = 0; k < joints_.size(); ++k) {
    for (int i = 0; i < 3; ++i) {
      double& offset = B[i * n + 4 * k + 3];
      offset -= middle[i];
      apart += offset * offset;
    }
  }
  curvature_ += q.A.trace();
  spread_ += q.A.trace() * apart / double(joints_.size());
  c_ += q(middle);
  size_ += q.A.trace() * middle.squaredNorm();
  (this->*kAdd[joints_.size() < kAdd.size() ? joints_.size() : 0])(q, middle, B.data());
}

// E under weights w, as a quadric of x - origin.
Quadric SkinnedQuadric::at(const Weights& w) const {
  const size_t n = rows();
  std::array<std::array<double, 4>, 4> sum{};
  Vec4 slope = Vec4::Zero();
  for (size_t k = 0; k < joints_.size(); ++k) {
    const double wk = w[Eigen::Index(k)];
    if (wk == 0) continue;
    for (size_t i = 0; i < 4; ++i) {
      const double* const row = &S_[(4 * k + i) * n];
      slope[Eigen::Index(i)] += wk * g_[4 * k + i];
      for (size_t j = 0; j < 4; ++j) sum[i][j] += wk * wk * row[4 * k + j];
      for (size_t l = k + 1; l < joints_.size(); ++l) {
        const double both = 2 * wk * w[Eigen::Index(l)];
        for (size_t j = 0; j < 4; ++j) sum[i][j] += both * row[4 * l + j];
      }
    }
  }
  Quadric q;
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) q.A(Eigen::Index(i), Eigen::Index(j)) = (sum[i][j] + sum[j][i]) / 2;
    q.b[Eigen::Index(i)] = (sum[i][3] + sum[3][i]) / 2 + slope[Eigen::Index(i)];
  }
  q.c = sum[3][3] + 2 * slope[3] + c_;
  return q;
}

double SkinnedQuadric::operator()(const Vec3& x, const Weights& w) const {
  return std::max(0.0, at(w)(x - origin_));
}

Vec3 SkinnedQuadric::best_position(const Weights& w, const Vec3& near) const {
  return origin_ + minimum(at(w), near - origin_);
}

// In the offset d from the start E is d'Hd + 2 r'd + E(start); with sum d = 0 only the differences between
// the joints' points matter, so H is taken about the point where the start has it.
Weights SkinnedQuadric::best_weights(const Vec3& x, const Weights& start, WeightRule rule) const {
  const auto K = Eigen::Index(joints_.size());
  if (K == 1) return start;
  const size_t n = rows();
  const Vec3 d = x - origin_;
  const std::array<double, 4> h = {d[0], d[1], d[2], 1};
  SmallMatrix H(K, K);
  Weights r(K);
  for (Eigen::Index k = 0; k < K; ++k) {
    const double *const row = &S_[4 * size_t(k) * n], *const g = &g_[4 * size_t(k)];
    r[k] = g[0] * h[0] + g[1] * h[1] + g[2] * h[2] + g[3];
    for (Eigen::Index l = k; l < K; ++l) {
      double sum = 0;
      for (size_t j = 0; j < 4; ++j) {
        const double* const at = row + 4 * size_t(l) + j;
        sum += h[j] * (h[0] * at[0] + h[1] * at[n] + h[2] * at[2 * n] + at[3 * n]);
      }
      H(k, l) = H(l, k) = sum;
    }
  }
  const Weights pull = H * start;
  const double level = pull.dot(start), middle = (r + pull).dot(start);
  // What there is to round: along planes the points may be far apart at no cost.
  const double size = spread_ + curvature_ * d.squaredNorm() + H.trace() / double(K);
  for (Eigen::Index k = 0; k < K; ++k) {
    r[k] += pull[k] - middle;
    for (Eigen::Index l = 0; l < K; ++l) H(k, l) += level - pull[k] - pull[l];
  }
  const double steepness = H.trace() / double(K);
  if (!(steepness > kAlike * size_ + kAlikeNear * size)) return start;
  const double ridge = kWeightRidge * steepness + kRounding * size;
  H.diagonal().array() += ridge;

  std::vector<int> free;
  free.reserve(size_t(K));
  for (int k = 0; k < K; ++k) free.push_back(k);
  if (rule == WeightRule::Signed) return start + constrained_step(H, r, free, ridge);

  // Primal active set: walk to the minimum over the free weights, stop where one reaches zero and hold it
  // there; when no step is left, free the weight that would lower E the most, if any.
  Weights w = start, slope = r;
  for (int turn = 0; turn < 4 * int(K); ++turn) {
    const Weights s = constrained_step(H, slope, free, ridge);
    double reach = 1;
    int blocking = -1;
    for (const int k : free) {
      if (s[k] < 0 && w[k] < -s[k] * reach) reach = w[k] / -s[k], blocking = k;
    }
    w += reach * s;
    slope = r + H * (w - start);
    if (blocking >= 0) {
      w[blocking] = 0;
      std::erase(free, blocking);
      continue;
    }
    const double least = slope[free.front()] - 1e-9 * steepness;
    int worst = -1;
    for (int k = 0; k < K; ++k) {
      const bool held = std::find(free.begin(), free.end(), k) == free.end();
      if (held && slope[k] < least && (worst < 0 || slope[k] < slope[worst])) worst = k;
    }
    if (worst < 0) break;
    free.insert(std::upper_bound(free.begin(), free.end(), worst), worst);
  }
  w = w.cwiseMax(0.0);
  return w / w.sum();
}

SkinnedQuadric SkinnedQuadric::over(std::span<const int> places) const {
  SkinnedQuadric some = *this;
  const size_t n = 4 * places.size();
  some.joints_.resize(places.size()), some.S_.resize(n * n), some.g_.resize(n);
  for (size_t k = 0; k < places.size(); ++k) {
    some.joints_[k] = joints_[places[k]];
    for (size_t i = 0; i < 4; ++i) {
      const size_t row = 4 * size_t(places[k]) + i;
      some.g_[4 * k + i] = g_[row];
      for (size_t l = k; l < places.size(); ++l) {
        const auto from = S_.begin() + std::ptrdiff_t(row * rows() + 4 * size_t(places[l]));
        std::copy(from, from + 4, some.S_.begin() + std::ptrdiff_t((4 * k + i) * n + 4 * l));
      }
    }
  }
  return some;
}

}  // namespace skinlod
