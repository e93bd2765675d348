// SPDX-License-Identifier: MIT
#include "pipeline/line_pairs.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "pipeline/charts.h"

namespace skinlod {
namespace {

// Of the rule of two points that integrates cubics along a line exactly.
constexpr double kNear = 0.21132486540518713;

// The charts on both sides of a line, the lower first.
using Sides = std::pair<int, int>;
constexpr int kNothing = -1;  // beside a border
constexpr int kUnknown = -2;  // a chart of the level that none of the original pairs with

// The lines of a surface between the same charts, and as a surface that can be asked for its closest point.
struct Lines {
  std::vector<HeldLine> lines{};
  Surface curve{};  // a face for each, its second end twice

  void add(const HeldLine& line, const Surface& s) {
    for (const int v : {line.edge.kept, line.edge.removed, line.edge.removed}) {
      curve.position.push_back(s.position[v]);
      curve.wedges.push_back({int(curve.position.size()) - 1, 0});
    }
    const int last = int(curve.wedges.size());
    curve.add_face(std::array{last - 3, last - 2, last - 1});
    lines.push_back(line);
  }
};

std::map<Sides, Lines> lines_by_sides(const Surface& s, const std::vector<int>& chart, LineWeights weights) {
  std::map<Sides, Lines> by_sides;
  for (const HeldLine& line : held_lines(Mesh(s), weights)) {
    const int a = chart[line.faces[0]], b = line.faces.size() > 1 ? chart[line.faces[1]] : kNothing;
    by_sides[std::minmax(a, b)].add(line, s);
  }
  return by_sides;
}

double length(const HeldLine& line, const Surface& s) {
  return (s.position[line.edge.removed] - s.position[line.edge.kept]).norm();
}

Vec3 at(const HeldLine& line, const Surface& s, double kept) {
  return kept * s.position[line.edge.kept] + (1 - kept) * s.position[line.edge.removed];
}

// `kept` is the share of that end.
Place place(const HeldLine& line, const Surface& s, int face, double kept) {
  Place place{face, Vec3::Zero()};
  const auto vertices = triangle_vertices(s, face);
  for (size_t k = 0; k < 3; ++k) {
    if (vertices[k] == line.edge.kept) place.share[Eigen::Index(k)] = kept;
    if (vertices[k] == line.edge.removed) place.share[Eigen::Index(k)] = 1 - kept;
  }
  return place;
}

}  // namespace

std::vector<LinePair> paired_lines(const Surface& original, const Surface& level, std::span<const Pair> pairs,
                                   LineWeights weights) {
  const std::vector<int> theirs = charts(original);
  std::vector<int> ours = charts(level);
  const std::map<int, int> origin = chart_origins(theirs, ours, pairs);
  for (int& chart : ours) {
    const auto found = origin.find(chart);
    chart = found == origin.end() ? kUnknown : found->second;
  }
  double area = 0;
  const Neighbourhood faces(level);
  for (int f = 0; f < level.face_count(); ++f) area += faces.vector_area(level.position, f).norm();

  std::vector<LinePair> found;
  if (!(area > 0)) return found;
  const auto of_original = lines_by_sides(original, theirs, weights);
  for (const auto& [sides, of_level] : lines_by_sides(level, ours, weights)) {
    const auto same = of_original.find(sides);
    if (same == of_original.end()) continue;
    const Lines &a = same->second, &b = of_level;
    const auto add = [&](int i, double kept_of_a, int j, double kept_of_b, double its_length) {
      const HeldLine &there = a.lines[i], &here = b.lines[j];
      const double across = length(here, level);
      if ((at(there, original, kept_of_a) - at(here, level, kept_of_b)).norm() > across) return;
      for (const int f : there.faces) {
        found.push_back({place(there, original, f, kept_of_a), place(here, level, here.faces[0], kept_of_b),
                         there.edge, there.weight * its_length / 2 * across / area});
      }
    };
    const PosedSurface on_a(a.curve, a.curve.position), on_b(b.curve, b.curve.position);
    for (const double kept : {kNear, 1 - kNear}) {
      for (int j = 0; j < int(b.lines.size()); ++j) {
        const ClosestPoint near = on_a.closest(at(b.lines[j], level, kept));
        add(near.face, near.share[0], j, kept, length(b.lines[j], level));
      }
      for (int i = 0; i < int(a.lines.size()); ++i) {
        const ClosestPoint near = on_b.closest(at(a.lines[i], original, kept));
        add(i, kept, near.face, near.share[0], length(a.lines[i], original));
      }
    }
  }
  return found;
}

}  // namespace skinlod
