// SPDX-License-Identifier: MIT
#include "pipeline/rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skinlod {

SinCos sin_cos(double angle) {
  // Cody and Waite: pi/2 in three pieces of 33 bits, so that a piece times a quarter count of up to 20 bits
  // is exact and the subtractions cancel without loss.
  constexpr double kPiece[] = {1.57079632673412561417e+00, 6.07710050630396597660e-11,
                               2.02226624871116645580e-21};
  const double quarters = std::floor(angle * (2 / std::numbers::pi) + 0.5);
  const double r = ((angle - quarters * kPiece[0]) - quarters * kPiece[1]) - quarters * kPiece[2];

  // Taylor's series, nested; |r| <= pi/4 makes the first term left out smaller than 1e-18.
  const double z = r * r;
  double s = 1, c = 1;
  for (int n = 18; n > 1; n -= 2) {
    s = 1 - z / (n * (n + 1)) * s;
    c = 1 - z / (n * (n - 1)) * c;
  }
  s *= r;
  switch (static_cast<long long>(quarters) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double atan2_exact(double y, double x) {
  const double wide = std::max(std::abs(x), std::abs(y)), narrow = std::min(std::abs(x), std::abs(y));
  if (wide == 0) return 0;
  double t = narrow / wide;  // the tangent of at most pi/4
  constexpr int kHalvings = 3;
  for (int i = 0; i < kHalvings; ++i) t /= 1 + std::sqrt(1 + t * t);

  // The series of the arc tangent, nested; t <= tan(pi/32) makes the first term left out smaller than 1e-19.
  const double z = t * t;
  double s = 0;
  for (int n = 17; n > 0; n -= 2) s = 1.0 / n - z * s;
  double angle = (1 << kHalvings) * (t * s);

  if (std::abs(y) > std::abs(x)) angle = std::numbers::pi / 2 - angle;
  if (x < 0) angle = std::numbers::pi - angle;
  return y < 0 ? -angle : angle;
}

Quat turn(const Vec3& axis, double angle) {
  const SinCos half = sin_cos(angle / 2);
  return Quat(axis.x() * half.sin, axis.y() * half.sin, axis.z() * half.sin, half.cos);
}

Quat turn(const Vec3& rotation_vector) {
  const double angle = rotation_vector.norm();
  return angle > 0 ? turn(Vec3(rotation_vector / angle), angle) : Quat(0, 0, 0, 1);
}

Vec3 rotation_vector(const Quat& q) {
  const double length = q.head<3>().norm();
  if (length == 0) return Vec3::Zero();
  // q and -q are the same rotation; the one with w >= 0 turns by at most pi.
  const double angle = 2 * atan2_exact(length, std::abs(q.w()));
  return q.head<3>() * ((q.w() < 0 ? -angle : angle) / length);
}

Quat multiply(const Quat& a, const Quat& b) {
  return Quat(a.w() * b.x() + a.x() * b.w() + a.y() * b.z() - a.z() * b.y(),
              a.w() * b.y() - a.x() * b.z() + a.y() * b.w() + a.z() * b.x(),
              a.w() * b.z() + a.x() * b.y() - a.y() * b.x() + a.z() * b.w(),
              a.w() * b.w() - a.x() * b.x() - a.y() * b.y() - a.z() * b.z());
}

Quat normalised(const Quat& q) {
  const double length = q.norm();
  return length > 0 && std::isfinite(length) ? Quat(q / length) : Quat(0, 0, 0, 1);
}

Mat3 matrix(const Quat& q) {
  const double x = q.x(), y = q.y(), z = q.z(), w = q.w();
  Mat3 m;
  m << 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
      2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),   //
      2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y);
  return m;
}

// Shepperd's method: each of the four squares can be read off the diagonal; start from the largest.
Quat quaternion(const Mat3& rotation) {
  const auto& m = rotation;
  const Vec4 squares(1 + m(0, 0) - m(1, 1) - m(2, 2), 1 - m(0, 0) + m(1, 1) - m(2, 2),
                     1 - m(0, 0) - m(1, 1) + m(2, 2), 1 + m(0, 0) + m(1, 1) + m(2, 2));
  Quat q;
  int largest = 0;
  squares.maxCoeff(&largest);
  if (largest == 3) {
    q << m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1), squares[3];
  } else {
    const int i = largest, j = (i + 1) % 3, k = (i + 2) % 3;
    q[i] = squares[i];
    q[j] = m(i, j) + m(j, i);
    q[k] = m(i, k) + m(k, i);
    q[3] = m(k, j) - m(j, k);
  }
  return normalised(q);
}

Quat slerp(const Quat& a, const Quat& b, double t) {
  const Quat end = a.dot(b) < 0 ? Quat(-b) : b;
  // From the chord, not from the arc cosine, which is blind where the ends nearly agree.
  const double angle = 2 * atan2_exact((end - a).norm(), (end + a).norm());
  if (angle < 1e-8) return normalised(a + t * (end - a));
  return normalised((sin_cos((1 - t) * angle).sin * a + sin_cos(t * angle).sin * end) / sin_cos(angle).sin);
}

}  // namespace skinlod
