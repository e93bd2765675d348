// SPDX-License-Identifier: MIT
#include "pipeline/fit_morphs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/charts.h"
#include "pipeline/fit.h"
#include "pipeline/morphs.h"
#include "pipeline/parallel.h"

namespace skinlod {
namespace {

// Two sides of a gap differ by more than this share of the larger offset, beyond what a face of the level
// spans.
constexpr double kAcrossGap = 0.5;

using Corners = std::vector<Fit::Corners>;  // per face
using Field = std::vector<Vec3>;            // what one target adds to each vertex, or each normal

Vec3 interpolated(const Field& field, const std::array<int, 3>& corners, const Vec3& share) {
  return share[0] * field[corners[0]] + share[1] * field[corners[1]] + share[2] * field[corners[2]];
}

double extent(const Field& field, const std::array<int, 3>& corners) {
  double most = 0;
  for (size_t k = 0; k < 3; ++k)
    most = std::max(most, (field[corners[k]] - field[corners[(k + 1) % 3]]).norm());
  return most;
}

bool is_still(const Field& field, const std::array<int, 3>& corners) {
  return std::all_of(corners.begin(), corners.end(), [&](int i) { return field[i].isZero(0); });
}

// One kind of offsets on both surfaces, and how they hang on the faces.
struct Sides {
  std::span<const Pair> pairs;
  Corners original, level;
};

// `there` is of the original, `start` of the level.
Field fitted(const Sides& sides, const Field& there, const Field& start) {
  std::vector<int> unknown(start.size(), -1);
  for (size_t f = 0; f < sides.level.size(); ++f) {
    if (is_still(start, sides.level[f])) continue;
    for (const int i : sides.level[f]) unknown[i] = 0;
  }
  for (const Pair& pair : sides.pairs) {
    if (is_still(there, sides.original[pair.original.face])) continue;
    for (const int i : sides.level[pair.level.face]) unknown[i] = 0;
  }
  std::vector<int> items;
  for (size_t i = 0; i < unknown.size(); ++i) {
    if (unknown[i] == 0) unknown[i] = int(items.size()), items.push_back(int(i));
  }
  Rows rows(Eigen::Index(items.size()), 3);
  for (size_t i = 0; i < items.size(); ++i) rows.row(Eigen::Index(i)) = start[items[i]].transpose();
  Corners rows_of;
  for (const auto& [a, b, c] : sides.level) rows_of.push_back({unknown[a], unknown[b], unknown[c]});
  Fit fit(std::move(rows), rows_of);
  for (const Pair& pair : sides.pairs) {
    const auto& corners = sides.level[pair.level.face];
    if (std::ranges::max(rows_of[pair.level.face]) < 0) continue;
    const Vec3 wanted = interpolated(there, sides.original[pair.original.face], pair.original.share);
    const Vec3 now = interpolated(start, corners, pair.level.share);
    const double most = std::sqrt(std::max(wanted.squaredNorm(), now.squaredNorm()));
    if ((wanted - now).norm() <= extent(start, corners) + kAcrossGap * most)
      fit.add(pair.level.face, pair.level.share, pair.area, wanted.transpose());
  }
  const Rows solved = fit.solve();
  Field field(start.size(), Vec3::Zero());
  for (size_t i = 0; i < items.size(); ++i) field[items[i]] = solved.row(Eigen::Index(i)).transpose();
  return field;
}

Field field_of(const std::vector<MorphOffsets>& lists, size_t count, int morph) {
  Field field(count, Vec3::Zero());
  for (size_t i = 0; i < lists.size(); ++i) field[i] = offset_of(lists[i], morph);
  return field;
}

Field sum(const Field& a, const Field& b) {
  Field both = a;
  for (size_t i = 0; i < a.size(); ++i) both[i] += b[i];
  return both;
}

// Corners of a face that is turned over go back to where the collapse had them, until there is none.
void turn_back(const Corners& faces, const Field& upright, const Field& rest, Field& offset) {
  const auto area = [](const Field& x, const std::array<int, 3>& f) {
    return Vec3((x[f[1]] - x[f[0]]).cross(x[f[2]] - x[f[0]]));
  };
  Field points = sum(rest, offset);
  std::vector<char> back(rest.size(), 0);
  for (bool more = true; more;) {
    more = false;
    for (const auto& face : faces) {
      const Vec3 was = area(upright, face);
      if (was.isZero(0) || area(points, face).dot(was) > 0) continue;
      for (const int v : face) {
        if (back[v]) continue;
        more = true, back[v] = 1;
        points[v] = upright[v], offset[v] = upright[v] - rest[v];
      }
    }
  }
}

// What one target leaves: items that it moves, ascending, and by how much.
using Moved = std::vector<std::pair<int, Vec3>>;

Moved moved(const Field& field) {
  Moved some;
  for (size_t i = 0; i < field.size(); ++i) {
    if (!field[i].isZero(0)) some.emplace_back(int(i), field[i]);
  }
  return some;
}

// Solves for each of `count` targets, and gives each item the offsets of all.
std::vector<MorphOffsets> offsets_of_all(int count, size_t items, const auto& solve) {
  std::vector<Moved> found;
  found.resize(size_t(count));
  parallel_for(count, [&](int m) { found[m] = moved(solve(m)); });
  std::vector<MorphOffsets> lists(items);
  for (int m = 0; m < count; ++m) {
    for (const auto& [i, delta] : found[m]) lists[i].push_back({m, delta});
  }
  return lists;
}

void fit_positions(const Surface& original, const Surface& before, std::span<const Pair> pairs, int count,
                   Surface& level) {
  Sides sides{pairs, {}, {}};
  for (int f = 0; f < original.face_count(); ++f) sides.original.push_back(triangle_vertices(original, f));
  for (int f = 0; f < level.face_count(); ++f) sides.level.push_back(triangle_vertices(level, f));
  const size_t vertices = level.position.size();
  level.morphs = offsets_of_all(count, vertices, [&](int m) {
    const Field there = field_of(original.morphs, original.position.size(), m);
    const Field start = field_of(before.morphs, vertices, m);
    Field offset = fitted(sides, there, start);
    turn_back(sides.level, sum(before.position, start), level.position, offset);
    return offset;
  });
}

// Wedges of a vertex that share a normal go on sharing it.
void fit_normals(const Surface& original, std::span<const Pair> pairs, int count, Surface& level) {
  const AttributeLayout& layout = level.layout;
  const std::vector<int> group = grouped(level, layout.normal_at(), layout.tangent_at(), false);
  const size_t groups = group.empty() ? 0 : size_t(std::ranges::max(group)) + 1;
  Sides sides{pairs, {}, {}};
  for (int f = 0; f < original.face_count(); ++f) {
    const auto w = original.face(f);
    sides.original.push_back({w[0], w[1], w[2]});
  }
  for (int f = 0; f < level.face_count(); ++f) {
    const auto w = level.face(f);
    sides.level.push_back({group[w[0]], group[w[1]], group[w[2]]});
  }
  std::vector<MorphOffsets> start(groups);
  for (size_t w = 0; w < level.normal_morphs.size(); ++w) start[group[w]] = level.normal_morphs[w];
  const auto lists = offsets_of_all(count, groups, [&](int m) {
    return fitted(sides, field_of(original.normal_morphs, original.wedges.size(), m),
                  field_of(start, groups, m));
  });
  level.normal_morphs.clear();
  for (const int g : group) level.normal_morphs.push_back(lists[g]);
}

}  // namespace

void fit_morphs(const Surface& original, const Surface& before, std::span<const Pair> pairs,
                const std::vector<char>& locked, Surface& level) {
  const int count = morph_count(original);
  if (!original.morphs.empty()) fit_positions(original, before, pairs, count, level);
  if (!original.normal_morphs.empty() && level.layout.normal) fit_normals(original, pairs, count, level);
  for (size_t v = 0; v < level.morphs.size(); ++v) {
    if (locked[v]) level.morphs[v] = before.morphs[v];
  }
  for (size_t w = 0; w < level.normal_morphs.size(); ++w) {
    if (locked[level.wedges[w].vertex]) level.normal_morphs[w] = before.normal_morphs[w];
  }
}

}  // namespace skinlod
