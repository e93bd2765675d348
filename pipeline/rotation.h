// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/skeleton.h"

/// Rotations made of + - * / and sqrt alone. glibc's sin, cos, acos and their kin give different last bits on
/// CPUs with and without FMA, and nothing on the way to an output may depend on the CPU.
namespace skinlod {

struct SinCos {
  double sin, cos;
};

/// Sine and cosine of `angle` (radians, any finite value up to 1e6), each within 1e-15 of the truth.
SinCos sin_cos(double angle);

/// The angle of the vector (x, y), in (-pi, pi], within 1e-15 of the truth. 0 for the zero vector.
double atan2_exact(double y, double x);

/// The rotation by `angle` (radians) about the unit vector `axis`.
Quat turn(const Vec3& axis, double angle);

/// The rotation about `rotation_vector` by its length in radians.
Quat turn(const Vec3& rotation_vector);

/// The unit axis of the rotation times its angle, which is at most pi: what `turn` undoes.
Vec3 rotation_vector(const Quat& q);

/// First `b`, then `a`.
Quat multiply(const Quat& a, const Quat& b);

/// q divided by its length; the identity where it has none.
Quat normalised(const Quat& q);

/// The rotation matrix of a unit quaternion.
Mat3 matrix(const Quat& q);

/// The unit quaternion of a rotation matrix.
Quat quaternion(const Mat3& rotation);

/// Along the shorter arc from unit quaternion `a` (t = 0) to `b` (t = 1), at constant speed.
Quat slerp(const Quat& a, const Quat& b, double t);

}  // namespace skinlod
