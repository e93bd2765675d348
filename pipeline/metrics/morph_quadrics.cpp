// SPDX-License-Identifier: MIT
#include "pipeline/metrics/morph_quadrics.h"

#include <algorithm>
#include <array>

#include "pipeline/attribute_quadrics.h"
#include "pipeline/metrics/surface_quadrics.h"
#include "pipeline/morphs.h"
#include "pipeline/side_by_side.h"

namespace skinlod {
namespace {

int morph_count(const Mesh& mesh) {
  int count = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (!mesh.morphs(v).empty()) count = std::max(count, mesh.morphs(v).back().morph + 1);
  }
  return count;
}

// |linear of (x, 1)|^2
Quadric squared(const Eigen::Matrix<double, 3, 4>& linear) {
  const auto G = linear.leftCols<3>();
  const Vec3 c = linear.col(3);
  return {G.transpose() * G, G.transpose() * c, c.squaredNorm()};
}

}  // namespace

MorphQuadrics::Sum& MorphQuadrics::Sum::operator+=(const Sum& other) {
  std::vector<Entry> both;
  for_each_entry(*this, other, [&](int morph, const Linear& linear) { both.push_back({morph, linear}); });
  area += other.area, squares += other.squares, entries = std::move(both);
  return *this;
}

void MorphQuadrics::for_each_entry(const Sum& a, const Sum& b, const auto& take) {
  const auto morph = [](const Entry& entry) { return entry.morph; };
  side_by_side(a.entries, b.entries, morph, [&](const Entry* i, const Entry* j) {
    take(i ? i->morph : j->morph, i && j ? Linear(i->linear + j->linear) : (i ? i : j)->linear);
  });
}

MorphQuadrics::MorphQuadrics(const Mesh& mesh) : count_(morph_count(mesh)) {
  if (count_ == 0) return;
  sums_.resize(mesh.position.size());
  for (int f = 0; f < mesh.face_slots(); ++f) {
    const auto face = mesh.face(f);
    for (size_t i = 2; i < face.size(); ++i) {
      const std::array<int, 3> corners = {face[0], face[i - 1], face[i]};
      const Sum sum = of_triangle(mesh, corners);
      for (const int v : corners) sums_[v] += sum;
    }
  }
}

MorphQuadrics::Sum MorphQuadrics::of_triangle(const Mesh& mesh, const std::array<int, 3>& corners) {
  Mat3 x;
  for (int k = 0; k < 3; ++k) x.col(k) = mesh.position[corners[k]];
  const LinearOnTriangle on_triangle(x);
  Sum sum{on_triangle.area() * mesh.error_weight(corners), {}, {}};
  if (!(sum.area > 0)) return {};
  std::vector<int> morphs;
  for (const int v : corners) {
    for (const MorphOffset& m : mesh.morphs(v)) morphs.push_back(m.morph);
  }
  std::sort(morphs.begin(), morphs.end());
  morphs.erase(std::unique(morphs.begin(), morphs.end()), morphs.end());
  for (const int morph : morphs) {
    Mat3 offsets;
    for (int k = 0; k < 3; ++k) offsets.col(k) = offset_of(mesh.morphs(corners[k]), morph);
    Linear linear;
    for (int axis = 0; axis < 3; ++axis) linear.row(axis) = on_triangle(offsets.row(axis)).transpose();
    sum.squares += sum.area * squared(linear);
    sum.entries.push_back({morph, sum.area * linear});
  }
  return sum;
}

Quadric MorphQuadrics::error(Edge e) const {
  if (sums_.empty()) return {};
  const Sum &a = sums_[e.kept], &b = sums_[e.removed];
  const double area = a.area + b.area;
  Quadric q = a.squares + b.squares;
  if (area > 0) for_each_entry(a, b, [&](int, const Linear& linear) { q += -1 / area * squared(linear); });
  return q;
}

MorphOffsets MorphQuadrics::best(Edge e, const Vec3& x) const {
  MorphOffsets offsets;
  if (sums_.empty()) return offsets;
  const Sum &a = sums_[e.kept], &b = sums_[e.removed];
  for_each_entry(a, b, [&](int morph, const Linear& linear) {
    const Vec3 delta = linear * x.homogeneous() / (a.area + b.area);
    if (!delta.isZero(0)) offsets.push_back({morph, delta});
  });
  return offsets;
}

void MorphQuadrics::solve(Edge e, Placement& to) const {
  if (!sums_.empty()) to.morphs = best(e, to.position);
}

double MorphQuadrics::blend(const Mesh& mesh, Edge e, Placement& to) const {
  if (sums_.empty()) return 0;
  to.morphs = skinlod::blend(mesh.morphs(e.kept), mesh.morphs(e.removed), mesh.way_along(e, to.position));
  double off = 0;
  const auto morph = [](const MorphOffset& m) { return m.morph; };
  side_by_side(*to.morphs, best(e, to.position), morph, [&](const MorphOffset* i, const MorphOffset* j) {
    off += ((i ? i->delta : Vec3(Vec3::Zero())) - (j ? j->delta : Vec3(Vec3::Zero()))).squaredNorm();
  });
  return (sums_[e.kept].area + sums_[e.removed].area) * off;
}

bool MorphQuadrics::turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const {
  if (sums_.empty()) return false;
  const auto corners = moved_corners(mesh, e);
  std::vector<int> morphs;
  const auto add = [&](std::span<const MorphOffset> offsets) {
    for (const MorphOffset& m : offsets) morphs.push_back(m.morph);
  };
  add(*to.morphs), add(mesh.morphs(e.kept)), add(mesh.morphs(e.removed));
  for (const auto& [moved, a, b] : corners) add(mesh.morphs(a)), add(mesh.morphs(b));
  std::sort(morphs.begin(), morphs.end());
  morphs.erase(std::unique(morphs.begin(), morphs.end()), morphs.end());
  for (const int morph : morphs) {
    const auto at = [&](int v) { return Vec3(mesh.position[v] + offset_of(mesh.morphs(v), morph)); };
    const Vec3 kept = at(e.kept), removed = at(e.removed), y = to.position + offset_of(*to.morphs, morph);
    for (const auto& [moved, a, b] : corners) {
      if (turns_over(moved == e.kept ? kept : removed, y, at(a), at(b))) return true;
    }
  }
  return false;
}

void MorphQuadrics::merge(Edge e) {
  if (sums_.empty()) return;
  sums_[e.kept] += sums_[e.removed];
  sums_[e.removed] = {};
}

}  // namespace skinlod
