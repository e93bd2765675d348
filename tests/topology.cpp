// SPDX-License-Identifier: MIT
#include "tests/topology.h"

#include <Eigen/Geometry>
#include <algorithm>
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

// By how much twice the area between two sides of a triangle can change when each corner goes as far as
// `reach`.
template <class Vector>
double room(double reach, const Vector& a, const Vector& b) {
  return reach * (a.norm() + b.norm() + (b - a).norm() + 3 * reach);
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

Traced traced(const Surface& source, const History& history, size_t steps) {
  Mesh mesh(source);
  std::vector<Influences> influences = source.influences;
  for (const auto& [edge, cost, position, weights, morphs] : std::span(history).first(steps)) {
    if (edge.removed >= 0) mesh.collapse(edge, position, morphs);
    influences[edge.kept] = weights;
  }
  Traced result{mesh.surface(influences), {}};
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face(f).empty()) result.face.push_back(f);
  }
  return result;
}

TurnedFaces turned_faces(const Surface& before, const Surface& after, std::span<const Pose> poses,
                         std::span<const int> face, const Reach& reach) {
  TurnedFaces result;
  for (const Pose& pose : poses) {
    const auto was = pose_vertices(before, pose.palette, pose.morph_weights);
    const auto is = pose_vertices(after, pose.palette, pose.morph_weights);
    for (int f = 0; f < after.face_count(); ++f) {
      const auto [a, b, c] = triangle_vertices(before, face.empty() ? f : face[f]);
      const Vec3 up = (was[b] - was[a]).cross(was[c] - was[a]);
      if (up.isZero(0)) continue;
      const auto [i, j, k] = triangle_vertices(after, f);
      double most = 0;
      for (const int v : {i, j, k}) most = std::max(most, reach ? reach(v, pose.palette) : 0);
      const Vec3 ij = is[j] - is[i], ik = is[k] - is[i];
      ++result.seen;
      result.turned += !(up.normalized().dot(ij.cross(ik)) + room(most, ij, ik) > 0);
    }
  }
  return result;
}

TurnedFaces turned_uvs(const Surface& before, const Surface& after, std::span<const int> face, double reach) {
  const auto sides = [](const Surface& s, int f, int set) {
    const auto uv = [&](size_t k) -> Vec2 {
      return s.attributes.row(s.face(f)[k]).segment<2>(s.layout.uv_at(set)).transpose();
    };
    return std::pair<Vec2, Vec2>(uv(1) - uv(0), uv(2) - uv(0));
  };
  const auto area = [](const std::pair<Vec2, Vec2>& ab) {
    return ab.first.x() * ab.second.y() - ab.first.y() * ab.second.x();
  };
  TurnedFaces result;
  for (int set = 0; set < after.layout.uv_sets; ++set) {
    for (int f = 0; f < after.face_count(); ++f) {
      const double was = area(sides(before, face.empty() ? f : face[f], set));
      if (was == 0) continue;
      const auto is = sides(after, f, set);
      ++result.seen;
      result.turned += !((was > 0 ? area(is) : -area(is)) + room(reach, is.first, is.second) > 0);
    }
  }
  return result;
}

int cracks(const Surface& surface, std::span<const int> point) {
  const auto same = [&](int a, int b) {
    const auto bits = [](const MorphOffset& m, const MorphOffset& n) {
      return m.morph == n.morph && m.delta == n.delta;
    };
    return surface.position[a] == surface.position[b] && surface.influences[a] == surface.influences[b] &&
           (surface.morphs.empty() || std::ranges::equal(surface.morphs[a], surface.morphs[b], bits));
  };
  std::map<int, int> first;  // vertex of each point
  int count = 0;
  for (size_t w = 0; w < surface.wedges.size(); ++w) {
    const int vertex = surface.wedges[w].vertex;
    count += !same(first.try_emplace(point[w], vertex).first->second, vertex);
  }
  return count;
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
