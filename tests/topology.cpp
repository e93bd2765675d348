// SPDX-License-Identifier: MIT
#include "tests/topology.h"

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "pipeline/mesh.h"

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

TurnedFaces turned_faces(const Surface& source, const History& history, std::span<const Pose> poses) {
  Mesh mesh(source);
  std::vector<Influences> influences = source.influences;
  TurnedFaces result;
  const auto normal = [&](int f, const Pose& pose) {
    std::array<Vec3, 3> x;
    for (size_t i = 0; i < 3; ++i) {
      const int v = mesh.face(f)[i];
      x[i] = mesh.position[v];
      for (const auto& [morph, delta] : mesh.morphs(v))
        x[i] += (pose.morph_weights.empty() ? 0 : pose.morph_weights[morph]) * delta;
      x[i] = transform(blend(influences[v], pose.palette), x[i]);
    }
    return Vec3((x[1] - x[0]).cross(x[2] - x[0]));
  };
  for (const auto& [edge, cost, position, weights, morphs] : history) {
    std::map<int, std::vector<Vec3>> before;
    for (const int v : {edge.kept, edge.removed}) {
      if (edge.removed < 0) break;
      for (const int f : mesh.faces_around(v)) {
        std::vector<Vec3> normals;
        for (const Pose& pose : poses) normals.push_back(normal(f, pose));
        before[f] = normals;
      }
    }
    if (edge.removed >= 0) mesh.collapse(edge, position, morphs);
    influences[edge.kept] = weights;
    for (const auto& [f, normals] : before) {
      if (mesh.face(f).empty()) continue;
      for (size_t p = 0; p < poses.size(); ++p) {
        ++result.seen;
        result.turned += normals[p].squaredNorm() > 0 && !(normals[p].dot(normal(f, poses[p])) > 0);
      }
    }
  }
  return result;
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
