// SPDX-License-Identifier: MIT
#include "pipeline/fit.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <utility>

#include "pipeline/parallel.h"

namespace skinlod {
namespace {

// How much every unknown holds on to what it was, against the mean of what draws at one.
constexpr double kHold = 1e-3;

}  // namespace

Fit::Fit(Rows start, std::vector<Corners> triangles)
    : start_(std::move(start)),
      pulled_(Rows::Zero(start_.rows(), start_.cols())),
      triangles_(std::move(triangles)),
      curvature_(triangles_.size(), Mat3::Zero()) {}

void Fit::add(int triangle, const Vec3& share, double weight, const Row& target) {
  curvature_[triangle] += weight * share * share.transpose();
  for (int i = 0; i < 3; ++i) {
    if (const int row = triangles_[triangle][i]; row >= 0) pulled_.row(row) += weight * share[i] * target;
  }
}

Rows Fit::solve() const {
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t f = 0; f < triangles_.size(); ++f) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const int row = triangles_[f][i], column = triangles_[f][j];
        if (row >= 0 && column >= 0 && curvature_[f](i, j) != 0)
          entries.emplace_back(row, column, curvature_[f](i, j));
      }
    }
  }
  if (entries.empty()) return start_;
  const auto count = int(start_.rows());
  Eigen::SparseMatrix<double> A(count, count);
  A.setFromTriplets(entries.begin(), entries.end());
  const double hold = kHold * A.diagonal().sum() / count;
  for (int g = 0; g < count; ++g) A.coeffRef(g, g) += hold;
  Rows solved = start_;
  parallel_for(int(solved.cols()), [&](int k) {
    // One for each column: Eigen's keeps the count of steps and the error of the solve that is under way.
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver(A);
    solver.setTolerance(1e-8);
    solved.col(k) = solver.solveWithGuess(pulled_.col(k) + hold * start_.col(k), start_.col(k)).eval();
  });
  return solved;
}

}  // namespace skinlod
