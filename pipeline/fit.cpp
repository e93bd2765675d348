// SPDX-License-Identifier: MIT
#include "pipeline/fit.h"

#include <Eigen/IterativeLinearSolvers>
#include <utility>

namespace skinlod {
namespace {

// How much every unknown holds on to what it was, against the mean of what draws at one.
constexpr double kHold = 1e-3;

}  // namespace

Fit::Fit(Rows start) : start_(std::move(start)), pulled_(Rows::Zero(start_.rows(), start_.cols())) {}

void Fit::add(const std::array<int, 3>& corners, const Vec3& share, double weight, const Row& target) {
  for (int i = 0; i < 3; ++i) {
    const double pull = weight * share[i];
    if (pull == 0 || corners[i] < 0) continue;
    pulled_.row(corners[i]) += pull * target;
    for (int j = 0; j < 3; ++j) {
      if (corners[j] >= 0) entries_.emplace_back(corners[i], corners[j], pull * share[j]);
    }
  }
}

Rows Fit::solve() const {
  if (entries_.empty()) return start_;
  const auto count = int(start_.rows());
  Eigen::SparseMatrix<double> A(count, count);
  A.setFromTriplets(entries_.begin(), entries_.end());
  const double hold = kHold * A.diagonal().sum() / count;
  for (int g = 0; g < count; ++g) A.coeffRef(g, g) += hold;
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver;
  solver.setTolerance(1e-8);
  solver.compute(A);
  Rows solved = start_;
  for (Eigen::Index k = 0; k < solved.cols(); ++k)
    solved.col(k) = solver.solveWithGuess(pulled_.col(k) + hold * start_.col(k), start_.col(k)).eval();
  return solved;
}

}  // namespace skinlod
