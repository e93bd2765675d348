// SPDX-License-Identifier: MIT
#pragma once

#include <random>

#include "pipeline/linalg.h"

/// Random values for property tests, from the raw output of a seeded engine: the same on every platform.
namespace skinlod {

inline double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}

/// A vector with components between -size and size.
inline Vec3 random_vector(std::mt19937& random, double size) {
  const double x = uniform(random, -size, size), y = uniform(random, -size, size);
  return Vec3(x, y, uniform(random, -size, size));
}

}  // namespace skinlod
