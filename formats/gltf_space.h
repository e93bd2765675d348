// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/linalg.h"

namespace skinlod {

/// How a surface is carried by an affine map: points, directions along it, and normals.
struct ChangeOfSpace {
  explicit ChangeOfSpace(const Affine& a) : map(a), along(a.leftCols<3>()), mirrors(along.determinant() < 0) {
    // The cofactors are the inverse transpose, but for a scale, and exist where the inverse does not.
    normal << along.col(1).cross(along.col(2)), along.col(2).cross(along.col(0)),
        along.col(0).cross(along.col(1));
    if (mirrors) normal = -normal;
  }

  Affine map;
  Mat3 along;
  Mat3 normal = {};
  bool mirrors;  // turns counter-clockwise faces, and the handedness of tangents, about
};

/// `x` divided by its length, or as it is where it has none.
inline Vec3 unit(const Vec3& x) {
  const double length = x.norm();
  return length > 0 ? Vec3(x / length) : x;
}

}  // namespace skinlod
