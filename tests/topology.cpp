// SPDX-License-Identifier: MIT
#include "tests/topology.h"

#include <Eigen/Geometry>
#include <map>
#include <numeric>
#include <random>
#include <set>

namespace skinlod {
namespace {

std::map<std::pair<int, int>, int> faces_per_edge(const Surface& s) {
  std::map<std::pair<int, int>, int> edges;
  for (int f = 0; f < s.face_count(); ++f) {
    const auto face = s.face(f);
    for (size_t i = 0; i < face.size(); ++i) {
      const int a = s.wedges[face[i]].vertex, b = s.wedges[face[(i + 1) % face.size()]].vertex;
      ++edges[std::minmax(a, b)];
    }
  }
  return edges;
}

}  // namespace

int euler_characteristic(const Surface& s) {
  std::set<int> used;
  for (const int w : s.corners) used.insert(s.wedges[w].vertex);
  return int(used.size()) - int(faces_per_edge(s).size()) + s.face_count();
}

int border_edges(const Surface& s) {
  int count = 0;
  for (const auto& [edge, faces] : faces_per_edge(s)) count += faces == 1;
  return count;
}

int border_loops(const Surface& s) {
  std::vector<int> root(s.position.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[v] != v) v = root[v];
    return v;
  };
  std::set<int> on_border;
  for (const auto& [edge, faces] : faces_per_edge(s)) {
    if (faces != 1) continue;
    root[find(edge.first)] = find(edge.second);
    on_border.insert({edge.first, edge.second});
  }
  std::set<int> loops;
  for (const int v : on_border) loops.insert(find(v));
  return int(loops.size());
}

double volume(const Surface& s) {
  double sum = 0;
  for (int f = 0; f < s.face_count(); ++f) {
    const auto face = s.face(f);
    const auto at = [&](size_t i) { return s.position[s.wedges[face[i]].vertex]; };
    sum += at(0).dot(at(1).cross(at(2))) / 6;
  }
  return sum;
}

double area(const Surface& s) {
  double sum = 0;
  for (int f = 0; f < s.face_count(); ++f) {
    const auto face = s.face(f);
    const auto at = [&](size_t i) { return s.position[s.wedges[face[i]].vertex]; };
    sum += (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2;
  }
  return sum;
}

Palette random_palette(int joints, unsigned seed, double angle, double shift) {
  std::mt19937 random(seed);
  const auto unit = [&] { return double(random()) / double(std::mt19937::max()) * 2 - 1; };
  Palette palette;
  for (int b = 0; b < joints; ++b) {
    Affine T;
    const Vec3 axis = Vec3(unit(), unit(), unit()).normalized();
    T.leftCols<3>() = Eigen::AngleAxisd(angle * unit(), axis).toRotationMatrix();
    T.col(3) = shift * Vec3(unit(), unit(), unit());
    palette.push_back(T);
  }
  return palette;
}

}  // namespace skinlod
