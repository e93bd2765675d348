// SPDX-License-Identifier: MIT
#include "pipeline/pairing.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "pipeline/importance.h"

namespace skinlod {
namespace {

// Above so many faces each is sampled as it is: the places would be ten million in all poses.
constexpr int kManyFaces = 40000;

struct Given {
  Place place;
  double area;
};

// Of a rule that integrates cubics over a triangle exactly.
constexpr double kCorner = 1.0 / 20, kEdge = 2.0 / 15, kMiddle = 9.0 / 20;

// A place on an edge, told apart from all others there: the same for all faces that share the edge.
struct OnEdge {
  int low, high, steps;  // its vertices, and how far from the lower one it is
  Given given;
  auto key() const { return std::tie(low, high, steps); }
};

// The corners, the middles of the edges and the middle of each of the n x n triangles of every face. What
// faces share is one place and stands for its part of all of them.
std::vector<Given> lattice_places(const Surface& s, int n) {
  using Steps = std::array<int, 3>;  // towards each corner, of 6n
  std::vector<Given> places, at_vertex(s.position.size(), {{-1, Vec3::Zero()}, 0});
  std::vector<OnEdge> on_edge;
  double total = 0;
  for (int f = 0; f < s.face_count(); ++f) {
    const auto v = triangle_vertices(s, f);
    const Vec3 x = s.position[v[0]];
    const double area = (s.position[v[1]] - x).cross(s.position[v[2]] - x).norm() / 2;
    if (!(area > 0)) continue;
    total += area;
    const auto add = [&](const Steps& at, double weight) {
      const Given given{{f, Vec3(at[0], at[1], at[2]) / (6.0 * n)}, weight * area / (n * n)};
      std::array<int, 2> ends{};
      int between = 0;
      for (int k = 0; k < 3; ++k) {
        if (at[k] == 0) continue;
        if (between < 2) ends[between] = k;
        ++between;
      }
      if (between == 1) {
        Given& there = at_vertex[v[ends[0]]];
        if (there.place.face < 0) there.place = given.place;
        there.area += given.area;
      } else if (between == 2) {
        if (v[ends[0]] > v[ends[1]]) std::swap(ends[0], ends[1]);
        on_edge.push_back({v[ends[0]], v[ends[1]], at[ends[1]], given});
      } else {
        places.push_back(given);
      }
    };
    const auto add_triangle = [&](const Steps& a, const Steps& b, const Steps& c) {
      Steps middle{};
      for (const auto& [from, to] : {std::pair(&a, &b), std::pair(&b, &c), std::pair(&c, &a)}) {
        Steps half{};
        for (size_t k = 0; k < 3; ++k) half[k] = ((*from)[k] + (*to)[k]) / 2, middle[k] += (*from)[k] / 3;
        add(*from, kCorner), add(half, kEdge);
      }
      add(middle, kMiddle);
    };
    const auto corner = [&](int i, int j) { return Steps{6 * (n - i - j), 6 * i, 6 * j}; };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        add_triangle(corner(i, j), corner(i + 1, j), corner(i, j + 1));
        if (i + j + 2 <= n) add_triangle(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
      }
    }
  }
  std::erase_if(at_vertex, [](const Given& given) { return given.place.face < 0; });
  places.insert(places.end(), at_vertex.begin(), at_vertex.end());
  std::stable_sort(on_edge.begin(), on_edge.end(),
                   [](const OnEdge& a, const OnEdge& b) { return a.key() < b.key(); });
  for (size_t i = 0; i < on_edge.size(); ++i) {
    if (i == 0 || on_edge[i - 1].key() != on_edge[i].key()) places.push_back({on_edge[i].given.place, 0});
    places.back().area += on_edge[i].given.area;
  }
  for (Given& given : places) given.area /= total;
  // By face, so that one after the other they are near each other.
  std::stable_sort(places.begin(), places.end(),
                   [](const Given& a, const Given& b) { return a.place.face < b.place.face; });
  return places;
}

}  // namespace

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

Vec3 Neighbourhood::at(std::span<const Vec3> points, const Place& place) const {
  const auto& [a, b, c] = vertices_[place.face];
  return place.share[0] * points[a] + place.share[1] * points[b] + place.share[2] * points[c];
}

Vec3 Neighbourhood::vector_area(std::span<const Vec3> points, int face) const {
  const auto& [a, b, c] = vertices_[face];
  return (points[b] - points[a]).cross(points[c] - points[a]) / 2;
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

std::vector<Pair> paired(const Surface& original, const Surface& level) {
  const PosedSurface a(original, original.position), b(level, level.position);
  const Neighbourhood of_original(original), of_level(level);
  std::vector<Pair> pairs;
  int guess = 0;
  const auto pair = [&](const Given& given, const PosedSurface& from, const PosedSurface& to, bool on_level) {
    const ClosestPoint there = to.closest(from.at(given.place.face, given.place.share), guess);
    guess = there.face;
    const Place sought{there.face, there.share};
    const Place &on_a = on_level ? sought : given.place, &on_b = on_level ? given.place : sought;
    if (look_alike(of_original.vector_area(original.position, on_a.face),
                   of_level.vector_area(level.position, on_b.face)))
      pairs.push_back(
          {on_a, on_b, on_level, given.area * error_weight(original, of_original.vertices(on_a.face))});
  };
  for (const Given& given : lattice_places(original, 1)) pair(given, a, b, false);
  guess = 0;
  const int n = level.face_count() > kManyFaces ? 1 : 2;
  for (const Given& given : lattice_places(level, n)) pair(given, b, a, true);
  return pairs;
}

}  // namespace skinlod
