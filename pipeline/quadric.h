// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/linalg.h"

namespace skinlod {

/// A quadratic function of a point: q(x) = x'Ax + 2b'x + c.
/// Built from planes it is a sum of squared distances weighted by area, so its unit is m^4;
/// the sum of two quadrics measures the sum of their errors.
struct Quadric {
  Mat3 A = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  double c = 0;

  double operator()(const Vec3& x) const { return x.dot(A * x) + 2 * b.dot(x) + c; }

  Quadric& operator+=(const Quadric& other) {
    A += other.A, b += other.b, c += other.c;
    return *this;
  }
  friend Quadric operator+(Quadric p, const Quadric& q) { return p += q; }
  friend Quadric operator*(double s, const Quadric& q) { return {s * q.A, s * q.b, s * q.c}; }
};

/// `weight` times the squared distance to the plane through `point` with unit `normal`.
Quadric plane_quadric(const Vec3& point, const Vec3& normal, double weight);

/// The quadric x -> q(Lx + t): what `q` says of a point before the affine map T = [L | t] moves it.
Quadric pulled_back(const Quadric& q, const Affine& T);

/// The minimum of `q` closest to `near`. Where `q` is flat (along an edge, on a plane) there are
/// many; a direction counts as flat below about `flatness` times the largest curvature.
Vec3 minimum(const Quadric& q, const Vec3& near, double flatness = 1e-6);

}  // namespace skinlod
