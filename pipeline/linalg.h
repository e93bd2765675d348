// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

/// The letters that mean the same thing in every file: v vertex, f face, b joint (bone), p pose,
/// k frame, q quadric, w weights, x position.
namespace skinlod {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d;
using Mat3 = Eigen::Matrix3d;
using VecX = Eigen::VectorXd;
using MatX = Eigen::MatrixXd;

/// A table with one row per item and one column per component.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// An affine map of space, [L | t]: x -> Lx + t. The missing last row is 0 0 0 1.
using Affine = Eigen::Matrix<double, 3, 4>;

inline Affine identity() {
  Affine a;
  a << Mat3::Identity(), Vec3::Zero();
  return a;
}

/// Where `a` takes the point `x`.
inline Vec3 transform(const Affine& a, const Vec3& x) { return a.leftCols<3>() * x + a.col(3); }

/// First `b`, then `a`.
inline Affine compose(const Affine& a, const Affine& b) {
  Affine ab;
  ab.leftCols<3>() = a.leftCols<3>() * b.leftCols<3>();
  ab.col(3) = transform(a, b.col(3));
  return ab;
}

/// True where `a` can be undone: its linear part has a determinant that is not lost in rounding.
inline bool invertible(const Affine& a) {
  const double size = a.leftCols<3>().cwiseAbs().maxCoeff();
  const double det = std::abs(a.leftCols<3>().determinant());
  return std::isfinite(det) && det > 1e-18 * size * size * size;
}

/// The map that undoes `a`, which must be invertible.
inline Affine inverse(const Affine& a) {
  Affine back;
  back.leftCols<3>() = a.leftCols<3>().inverse();
  back.col(3) = -(back.leftCols<3>() * a.col(3));
  return back;
}

}  // namespace skinlod
