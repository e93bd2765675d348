// SPDX-License-Identifier: MIT
#include "pipeline/fit_attributes.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "pipeline/facets.h"
#include "pipeline/pairing.h"

namespace skinlod {
namespace {

// How much every unknown holds on to what it was, against the mean of what draws at one.
constexpr double kHold = 1e-3;

// A pair whose normals differ by more than 60 degrees lies across a hard edge.
constexpr double kHardEdge = 0.5;

// What is shorter than this points nowhere: the directions around it cancel.
constexpr double kNoDirection = 0.1;

using Row = Eigen::RowVectorXd;

Row interpolated(const Surface& s, const Place& place, int from, int size) {
  Row row = Row::Zero(size);
  const auto face = s.face(place.face);
  for (int k = 0; k < 3; ++k) row += place.share[k] * s.attributes.row(face[k]).segment(from, size);
  return row;
}

// Some columns of the attribute table as unknowns, one row of them for each group of wedges.
class Fit {
 public:
  Fit(Surface& level, int from, int size, const std::vector<int>& group)
      : level_(level), from_(from), size_(size), group_(group) {
    count_ = group.empty() ? 0 : *std::max_element(group.begin(), group.end()) + 1;
    pulled_ = Rows::Zero(count_, size);
  }

  void add(const Pair& pair, const Row& target) {
    const auto face = level_.face(pair.level.face);
    for (int i = 0; i < 3; ++i) {
      const double pull = pair.area * pair.level.share[i];
      if (pull == 0) continue;
      pulled_.row(group_[face[i]]) += pull * target;
      for (int j = 0; j < 3; ++j)
        entries_.emplace_back(group_[face[i]], group_[face[j]], pull * pair.level.share[j]);
    }
  }

  // One row per group.
  Rows solve() {
    Rows now = Rows::Zero(count_, size_);
    for (size_t w = 0; w < group_.size(); ++w)
      now.row(group_[w]) = level_.attributes.row(Eigen::Index(w)).segment(from_, size_);
    if (entries_.empty()) return now;
    Eigen::SparseMatrix<double> A(count_, count_);
    A.setFromTriplets(entries_.begin(), entries_.end());
    const double hold = kHold * A.diagonal().sum() / count_;
    for (int g = 0; g < count_; ++g) A.coeffRef(g, g) += hold;
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver;
    solver.setTolerance(1e-8);
    solver.compute(A);
    for (int k = 0; k < size_; ++k)
      now.col(k) = solver.solveWithGuess(pulled_.col(k) + hold * now.col(k), now.col(k)).eval();
    return now;
  }

 private:
  Surface& level_;
  int from_, size_;
  const std::vector<int>& group_;
  int count_;
  std::vector<Eigen::Triplet<double>> entries_;
  Rows pulled_;
};

// Wedges of one vertex that agree in some columns, as one; and in their part, where that is asked for.
std::vector<int> grouped(const Surface& s, int from, int to, bool by_part) {
  std::map<std::vector<double>, int> known;
  std::vector<int> group;
  for (size_t w = 0; w < s.wedges.size(); ++w) {
    std::vector<double> key = {double(s.wedges[w].vertex), by_part ? double(s.wedges[w].part) : 0};
    for (int k = from; k < to; ++k) key.push_back(s.attributes(Eigen::Index(w), k));
    group.push_back(known.emplace(std::move(key), int(known.size())).first->second);
  }
  return group;
}

void fit_directions(const Surface& original, Surface& level, const std::vector<Pair>& pairs,
                    const std::vector<char>& locked, int from, int to) {
  const std::vector<int> group = grouped(level, from, to, false);
  Fit fit(level, from, 3, group);
  for (const Pair& pair : pairs) {
    const Row there = interpolated(original, pair.original, from, 3);
    const Row here = interpolated(level, pair.level, from, 3);
    if (there.dot(here) > kHardEdge * there.norm() * here.norm()) fit.add(pair, there.normalized());
  }
  const Rows fitted = fit.solve();
  for (size_t w = 0; w < group.size(); ++w) {
    const Row direction = fitted.row(group[w]);
    if (!locked[level.wedges[w].vertex] && direction.norm() > kNoDirection)
      level.attributes.row(Eigen::Index(w)).segment(from, 3) = direction.normalized();
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

void fit_uvs(const Surface& original, Surface& level, const std::vector<Pair>& pairs,
             const std::vector<char>& locked) {
  const std::vector<int> sheet =
      grouped(level, level.layout.uv_at(0), level.layout.uv_at(level.layout.uv_sets), true);
  for (int set = 0; set < level.layout.uv_sets; ++set) {
    const int at = level.layout.uv_at(set);
    Fit fit(level, at, 2, sheet);
    for (const Pair& pair : pairs) {
      const Row there = interpolated(original, pair.original, at, 2);
      const Row here = interpolated(level, pair.level, at, 2);
      if ((there - here).norm() <= uv_extent(level, pair.level.face, at)) fit.add(pair, there);
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

// Faces that hang together in texture space, as one number for each: a chart. Without uvs, a part.
std::vector<int> charts(const Surface& s) {
  const std::vector<int> sheet = grouped(s, s.layout.uv_at(0), s.layout.uv_at(s.layout.uv_sets), true);
  std::vector<int> leader(s.wedges.size());
  std::iota(leader.begin(), leader.end(), 0);
  const auto root = [&](int w) {
    while (leader[w] != w) w = leader[w] = leader[leader[w]];
    return w;
  };
  for (int f = 0; f < s.face_count(); ++f) {
    for (const int w : s.face(f)) {
      const int a = root(sheet[s.face(f)[0]]), b = root(sheet[w]);
      leader[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<int> chart;
  for (int f = 0; f < s.face_count(); ++f) chart.push_back(root(sheet[s.face(f)[0]]));
  return chart;
}

// Leaves the pairs that lie in the chart of the original that the level's chart is made of: the one where
// most of its area finds its pairs. Others lie across a seam, or on another layer of clothes.
void drop_foreign_pairs(std::vector<Pair>& pairs, const Surface& original, const Surface& level) {
  const std::vector<int> theirs = charts(original), ours = charts(level);
  std::map<std::pair<int, int>, double> shared;
  for (const Pair& pair : pairs) shared[{ours[pair.level.face], theirs[pair.original.face]}] += pair.area;
  std::map<int, std::pair<double, int>> most;
  for (const auto& [both, area] : shared) {
    auto& best = most[both.first];
    if (area > best.first) best = {area, both.second};
  }
  std::erase_if(pairs, [&](const Pair& pair) {
    return theirs[pair.original.face] != most[ours[pair.level.face]].second;
  });
}

}  // namespace

void fit_attributes(const Surface& original, const Surface& before, Surface& level,
                    const std::vector<char>& locked) {
  const AttributeLayout& layout = level.layout;
  if (!layout.normal && !layout.tangent && layout.uv_sets == 0) return;
  std::vector<Pair> pairs = paired(original, level);
  drop_foreign_pairs(pairs, original, level);
  fit_uvs(original, level, pairs, locked);
  if (layout.normal) {
    fit_directions(original, level, pairs, locked, layout.normal_at(), layout.tangent_at());
    shade_flat(level, flat_wedges(before));
  }
  if (!layout.tangent) return;
  fit_directions(original, level, pairs, locked, layout.tangent_at(), layout.uv_at(0));
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
