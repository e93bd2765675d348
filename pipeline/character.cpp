// SPDX-License-Identifier: MIT
#include "pipeline/character.h"

#include <algorithm>
#include <array>

namespace skinlod {
namespace {

// Twice the area vector of a polygon (Newell): right for polygons that are concave or not quite planar.
Vec3 area_vector(std::span<const Vec3> x) {
  Vec3 sum = Vec3::Zero();
  for (size_t i = 1; i + 1 < x.size(); ++i) sum += (x[i] - x[0]).cross(x[i + 1] - x[0]);
  return sum;
}

// Where the triangle a b c, seen along `normal`, turns left and leaves every other corner outside.
bool is_ear(const std::array<Vec3, 3>& ear, std::span<const Vec3> others, const Vec3& normal) {
  if ((ear[1] - ear[0]).cross(ear[2] - ear[1]).dot(normal) <= 0) return false;
  return std::none_of(others.begin(), others.end(), [&](const Vec3& x) {
    for (size_t i = 0; i < 3; ++i) {
      if (x == ear[i]) return false;  // a polygon that touches itself, as a hole that is bridged does
      if ((ear[(i + 1) % 3] - ear[i]).cross(x - ear[i]).dot(normal) < 0) return false;
    }
    return true;
  });
}

// The tip of the next ear to cut off the polygon `wedge`: of the legal ones that with the shortest new edge,
// the first of equals. 1, the next triangle of the fan from corner 0, where no ear is legal.
size_t next_ear(std::span<const int> wedge, const Surface& surface) {
  const size_t n = wedge.size();
  std::vector<Vec3> x(n);
  for (size_t i = 0; i < n; ++i) x[i] = surface.position[surface.wedges[wedge[i]].vertex];
  const Vec3 normal = area_vector(x);
  std::vector<std::pair<double, size_t>> candidates;
  for (size_t i = 0; i < n; ++i)
    candidates.push_back({(x[(i + 1) % n] - x[(i + n - 1) % n]).squaredNorm(), i});
  std::sort(candidates.begin(), candidates.end());
  for (const auto& [length, i] : candidates) {
    if (is_ear({x[(i + n - 1) % n], x[i], x[(i + 1) % n]}, x, normal)) return i;
  }
  return 1;
}

// Clipping is cubic at worst. No polygon that someone modelled has more corners than this, and one that
// someone forged must not hang us: it becomes a plain fan.
constexpr size_t kMostCornersToClip = 64;

}  // namespace

std::array<int, 3> triangle_vertices(const Surface& surface, int f) {
  const auto face = surface.face(f);
  const auto vertex = [&](int corner) { return surface.wedges[face[corner]].vertex; };
  return {vertex(0), vertex(1), vertex(2)};
}

int triangle_count(const Surface& surface) {
  int count = 0;
  for (int f = 0; f < surface.face_count(); ++f) count += std::max(0, int(surface.face(f).size()) - 2);
  return count;
}

bool is_triangulated(const Surface& surface) {
  for (int f = 0; f < surface.face_count(); ++f) {
    if (surface.face(f).size() != 3) return false;
  }
  return true;
}

Surface triangulated(const Surface& surface) {
  Surface cut = surface;
  cut.corners.clear();
  cut.face_begin = {0};
  for (int f = 0; f < surface.face_count(); ++f) {
    const auto face = surface.face(f);
    if (face.size() > kMostCornersToClip) {
      for (size_t i = 1; i + 1 < face.size(); ++i) cut.add_face(std::array{face[0], face[i], face[i + 1]});
      continue;
    }
    std::vector<int> left(face.begin(), face.end());
    while (left.size() > 3) {
      const size_t n = left.size(), i = next_ear(left, surface);
      cut.add_face(std::array{left[(i + n - 1) % n], left[i], left[(i + 1) % n]});
      left.erase(left.begin() + std::ptrdiff_t(i));
    }
    if (left.size() == 3) cut.add_face(left);
  }
  return cut;
}

Eigen::RowVectorXd default_attributes(const AttributeLayout& layout) {
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(layout.columns());
  if (layout.normal) row[layout.normal_at() + 2] = 1;
  if (layout.tangent) row[layout.tangent_at()] = row[layout.tangent_at() + 3] = 1;
  row.tail(4 * layout.colour_sets).setOnes();
  return row;
}

AttributeLayout joined(const AttributeLayout& a, const AttributeLayout& b) {
  return {.normal = a.normal || b.normal,
          .tangent = a.tangent || b.tangent,
          .uv_sets = std::max(a.uv_sets, b.uv_sets),
          .colour_sets = std::max(a.colour_sets, b.colour_sets)};
}

Rows widened(const Rows& table, const AttributeLayout& from, const AttributeLayout& to) {
  Rows wide = default_attributes(to).replicate(table.rows(), 1);
  if (from.normal) wide.middleCols<3>(to.normal_at()) = table.middleCols<3>(from.normal_at());
  if (from.tangent) wide.middleCols<4>(to.tangent_at()) = table.middleCols<4>(from.tangent_at());
  wide.middleCols(to.uv_at(0), 2 * from.uv_sets) = table.middleCols(from.uv_at(0), 2 * from.uv_sets);
  wide.middleCols(to.colour_at(0), 4 * from.colour_sets) =
      table.middleCols(from.colour_at(0), 4 * from.colour_sets);
  return wide;
}

double Clip::duration() const {
  double end = 0;
  for (const Channel& channel : channels) {
    if (!channel.times.empty()) end = std::max(end, channel.times.back());
  }
  return end;
}

double diagonal(std::span<const Vec3> positions) {
  if (positions.empty()) return 0;
  Vec3 low = positions[0], high = positions[0];
  for (const Vec3& x : positions) low = low.cwiseMin(x), high = high.cwiseMax(x);
  return (high - low).norm();
}

}  // namespace skinlod
