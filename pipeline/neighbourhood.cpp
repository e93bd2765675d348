// SPDX-License-Identifier: MIT
#include "pipeline/neighbourhood.h"

#include <algorithm>

namespace skinlod {

Neighbourhood::Neighbourhood(const Surface& surface) : begin_(surface.position.size() + 1, 0) {
  for (int f = 0; f < surface.face_count(); ++f) {
    vertices_.push_back(triangle_vertices(surface, f));
    for (const int v : vertices_.back()) ++begin_[v + 1];
  }
  for (size_t v = 1; v < begin_.size(); ++v) begin_[v] += begin_[v - 1];
  around_.resize(size_t(begin_.back()));
  std::vector<int> next(begin_.begin(), begin_.end() - 1);
  for (int f = 0; f < face_count(); ++f) {
    for (const int v : vertices_[f]) around_[next[v]++] = f;
  }
}

Place Neighbourhood::closest(std::span<const Vec3> points, const Vec3& x, int face) const {
  const auto look = [&](int f) {
    const auto& [a, b, c] = vertices_[f];
    return Place{f, closest_shares(x, points[a], points[b], points[c])};
  };
  Place best = look(face);
  double squared = (x - at(points, best)).squaredNorm();
  for (bool closer = true; closer;) {
    closer = false;
    // Only what touches the closest point can be closer.
    const auto& corners = vertices_[best.face];
    size_t on = 0;
    std::array<int, 3> touched{};
    for (size_t k = 0; k < 3; ++k) {
      if (best.share[Eigen::Index(k)] > 0) touched[on++] = corners[k];
    }
    if (on == 3) break;
    const int before = best.face;
    for (const int f : faces_around(touched[0])) {
      const auto& other = vertices_[f];
      const bool touches = on == 1 || std::find(other.begin(), other.end(), touched[1]) != other.end();
      if (f == before || !touches) continue;
      const Place there = look(f);
      const double its = (x - at(points, there)).squaredNorm();
      if (its < squared) squared = its, best = there, closer = true;
    }
  }
  return best;
}

}  // namespace skinlod
