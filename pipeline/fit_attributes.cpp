// SPDX-License-Identifier: MIT
#include "pipeline/fit_attributes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/charts.h"
#include "pipeline/facets.h"
#include "pipeline/fit.h"
#include "pipeline/parallel.h"

namespace skinlod {
namespace {

// A pair whose normals differ by a right angle lies across a hard edge. With 60 degrees what a level blunts
// is left out too: normals are 1 % worse.
constexpr double kHardEdge = 0;

// What is shorter than this points nowhere: the directions around it cancel.
constexpr double kNoDirection = 0.1;

using Row = Fit::Row;

Row interpolated(const Surface& s, const Place& place, int from, int size) {
  Row row = Row::Zero(size);
  const auto face = s.face(place.face);
  for (int k = 0; k < 3; ++k) row += place.share[k] * s.attributes.row(face[k]).segment(from, size);
  return row;
}

// Some columns of the attribute table, one row of them for each group of wedges.
Rows start_of(const Surface& level, int from, int size, const std::vector<int>& group) {
  Rows now = Rows::Zero(group.empty() ? 0 : *std::max_element(group.begin(), group.end()) + 1, size);
  for (size_t w = 0; w < group.size(); ++w)
    now.row(group[w]) = level.attributes.row(Eigen::Index(w)).segment(from, size);
  return now;
}

// Some columns of the attribute table, the same for all wedges of a group.
Fit fit_of(const Surface& level, int from, int size, const std::vector<int>& group) {
  std::vector<Fit::Corners> triangles;
  for (int f = 0; f < level.face_count(); ++f) {
    const auto w = level.face(f);
    triangles.push_back({group[w[0]], group[w[1]], group[w[2]]});
  }
  return {start_of(level, from, size, group), std::move(triangles)};
}

void fit_directions(const Surface& original, Surface& level, std::span<const Pair> pairs,
                    const std::vector<char>& locked, int from, int to) {
  const std::vector<int> group = grouped(level, from, to, false);
  Fit fit = fit_of(level, from, 3, group);
  for (const Pair& pair : pairs) {
    const Row there = interpolated(original, pair.original, from, 3);
    const Row here = interpolated(level, pair.level, from, 3);
    if (there.dot(here) > kHardEdge * there.norm() * here.norm())
      fit.add(pair.level.face, pair.level.share, pair.area, there.normalized());
  }
  const Rows fitted = fit.solve();
  for (size_t w = 0; w < group.size(); ++w) {
    const Vec3 direction = fitted.row(group[w]).transpose();
    if (!locked[level.wedges[w].vertex] && direction.norm() > kNoDirection)
      level.attributes.row(Eigen::Index(w)).segment<3>(from) = direction.normalized();
  }
}

// Twice the area that a face covers in one uv set.
double uv_area(const Surface& s, int f, int at) {
  const auto w = s.face(f);
  const auto uv = [&](int k) -> Vec2 { return s.attributes.row(w[k]).segment<2>(at).transpose(); };
  const Vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
  return a.x() * b.y() - a.y() * b.x();
}

double uv_extent(const Surface& s, int f, int at) {
  const auto w = s.face(f);
  double most = 0;
  for (int k = 0; k < 3; ++k)
    most = std::max(most, (s.attributes.row(w[k]) - s.attributes.row(w[(k + 1) % 3])).segment<2>(at).norm());
  return most;
}

void fit_uvs(const Surface& original, Surface& level, std::span<const Pair> pairs,
             const std::vector<char>& locked) {
  const std::vector<int> sheet = sheets(level);
  for (int set = 0; set < level.layout.uv_sets; ++set) {
    const int at = level.layout.uv_at(set);
    Fit fit = fit_of(level, at, 2, sheet);
    for (const Pair& pair : pairs) {
      const Row there = interpolated(original, pair.original, at, 2);
      const Row here = interpolated(level, pair.level, at, 2);
      if ((there - here).norm() <= uv_extent(level, pair.level.face, at))
        fit.add(pair.level.face, pair.level.share, pair.area, there);
    }
    const Rows fitted = fit.solve();
    const Rows old = level.attributes.middleCols(at, 2);
    std::vector<double> area(size_t(level.face_count()));
    for (int f = 0; f < level.face_count(); ++f) area[f] = uv_area(level, f, at);
    // Sheets around a triangle that is turned over go back to what they were, until there is none.
    std::vector<char> back(size_t(fitted.rows()), 0);
    for (size_t w = 0; w < sheet.size(); ++w) back[sheet[w]] = locked[level.wedges[w].vertex];
    for (bool more = true; more;) {
      for (size_t w = 0; w < sheet.size(); ++w) {
        const auto row = Eigen::Index(w);
        level.attributes.row(row).segment(at, 2) =
            back[sheet[w]] ? Row(old.row(row)) : Row(fitted.row(sheet[w]));
      }
      more = false;
      for (int f = 0; f < level.face_count(); ++f) {
        if (area[f] == 0 || uv_area(level, f, at) * area[f] > 0) continue;
        for (const int w : level.face(f)) more = more || !back[sheet[w]], back[sheet[w]] = 1;
      }
    }
  }
}

}  // namespace

void fit_attributes(const Surface& original, const Surface& before, std::span<const Pair> pairs,
                    const std::vector<char>& locked, Surface& level) {
  const AttributeLayout& layout = level.layout;
  if (!layout.normal && !layout.tangent && layout.uv_sets == 0) return;
  in_parallel({[&] { fit_uvs(original, level, pairs, locked); },
               [&] {
                 if (!layout.normal) return;
                 fit_directions(original, level, pairs, locked, layout.normal_at(), layout.tangent_at());
                 shade_flat(level, flat_wedges(before));
               },
               [&] {
                 if (!layout.tangent) return;
                 fit_directions(original, level, pairs, locked, layout.tangent_at(), layout.uv_at(0));
               }});
  if (!layout.tangent) return;
  for (Eigen::Index w = 0; layout.normal && w < level.attributes.rows(); ++w) {
    if (locked[level.wedges[size_t(w)].vertex]) continue;
    const Vec3 n = level.attributes.row(w).segment<3>(layout.normal_at());
    const Vec3 t = level.attributes.row(w).segment<3>(layout.tangent_at());
    const Vec3 in_plane = t - n.dot(t) * n;
    if (in_plane.norm() > kNoDirection)
      level.attributes.row(w).segment<3>(layout.tangent_at()) = in_plane.normalized();
  }
}

}  // namespace skinlod
