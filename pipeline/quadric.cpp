// SPDX-License-Identifier: MIT
#include "pipeline/quadric.h"

#include <Eigen/Cholesky>

namespace skinlod {

Quadric plane_quadric(const Vec3& point, const Vec3& normal, double weight) {
  const double d = -normal.dot(point);
  return {weight * normal * normal.transpose(), weight * d * normal, weight * d * d};
}

Quadric pulled_back(const Quadric& q, const Affine& T) {
  const Mat3 L = T.leftCols<3>();
  const Vec3 t = T.col(3);
  const Mat3 Al = q.A * L;
  return {L.transpose() * Al, L.transpose() * (q.A * t + q.b), q(t)};
}

// A ridge stands in for the pseudo-inverse: it leaves flat directions where they are and costs one small
// factorisation. Its bias in the steep directions is the square of flatness after the second step, which
// reuses the factor.
Vec3 minimum(const Quadric& q, const Vec3& near, double flatness) {
  const double steepest = q.A.trace();
  if (!(steepest > 0)) return near;
  const Eigen::LLT<Mat3> factor(q.A + flatness * steepest * Mat3::Identity());
  Vec3 x = near;
  for (int step = 0; step < 2; ++step) x -= factor.solve(q.A * x + q.b);
  return x;
}

}  // namespace skinlod
