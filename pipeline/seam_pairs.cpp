// SPDX-License-Identifier: MIT
#include "pipeline/seam_pairs.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "pipeline/importance.h"

namespace skinlod {
namespace {

// Of the rule of two points that integrates cubics along a line exactly.
constexpr double kNear = 0.21132486540518713;

// The charts on both sides of a seam, the lower first.
using Sides = std::pair<int, int>;
constexpr int kUnknown = -1;  // a chart of the level that none of the original pairs with

// The edges of a surface between the same charts, and as a surface that can be asked for its closest point.
struct Seam {
  std::vector<SeamLine> lines{};
  Surface curve{};  // a face for each, its second end twice

  void add(const SeamLine& line, const Surface& s) {
    for (const int v : {line.edge.kept, line.edge.removed, line.edge.removed}) {
      curve.position.push_back(s.position[v]);
      curve.wedges.push_back({int(curve.position.size()) - 1, 0});
    }
    const int last = int(curve.wedges.size());
    curve.add_face(std::array{last - 3, last - 2, last - 1});
    lines.push_back(line);
  }
};

std::map<Sides, Seam> seams_by_sides(const Surface& s, const std::vector<SeamLine>& lines,
                                     const std::vector<int>& chart) {
  std::map<Sides, Seam> seams;
  for (const SeamLine& line : lines)
    seams[std::minmax(chart[line.faces[0]], chart[line.faces[1]])].add(line, s);
  return seams;
}

double length(const SeamLine& line, const Surface& s) {
  return (s.position[line.edge.removed] - s.position[line.edge.kept]).norm();
}

// `kept` is the share of that end.
Vec3 at(const SeamLine& line, const Surface& s, double kept) {
  return kept * s.position[line.edge.kept] + (1 - kept) * s.position[line.edge.removed];
}

Place place(const SeamLine& line, const Surface& s, int face, double kept) {
  Place place{face, Vec3::Zero()};
  const auto vertices = triangle_vertices(s, face);
  for (size_t k = 0; k < 3; ++k) {
    if (vertices[k] == line.edge.kept) place.share[Eigen::Index(k)] = kept;
    if (vertices[k] == line.edge.removed) place.share[Eigen::Index(k)] = 1 - kept;
  }
  return place;
}

double area(const Surface& s, const Neighbourhood& faces) {
  double sum = 0;
  for (int f = 0; f < s.face_count(); ++f) sum += faces.vector_area(s.position, f).norm();
  return sum;
}

}  // namespace

std::vector<SeamPair> paired_seams(const Original& original, const Surface& level,
                                   std::span<const Pair> pairs) {
  const Surface& source = original.surface;
  const Neighbourhood faces(level);
  std::vector<int> ours = charts(level);
  const std::map<int, int> origins = chart_origins(original.charts, ours, pairs);
  for (int& chart : ours) {
    const auto origin = origins.find(chart);
    chart = origin == origins.end() ? kUnknown : origin->second;
  }
  std::vector<SeamPair> found;
  const double whole = area(level, faces);
  if (!(whole > 0)) return found;
  const auto of_original = seams_by_sides(source, original.seams, original.charts);
  for (const auto& [sides, of_level] : seams_by_sides(level, seam_lines(level, faces), ours)) {
    const auto same = of_original.find(sides);
    if (same == of_original.end()) continue;
    const Seam &a = same->second, &b = of_level;
    // Farther away than the level's edge is long it is another stretch of the seam.
    const auto add = [&](int i, double kept_of_a, int j, double kept_of_b, double its_length) {
      const SeamLine &there = a.lines[i], &here = b.lines[j];
      const double edge = length(here, level);
      if ((at(there, source, kept_of_a) - at(here, level, kept_of_b)).norm() > edge) return;
      const double weight = error_weight(source, std::array{there.edge.kept, there.edge.removed});
      for (const int f : there.faces)
        found.push_back({place(there, source, f, kept_of_a), place(here, level, here.faces[0], kept_of_b),
                         there.edge, weight * its_length / 2 * edge / whole});
    };
    const PosedSurface on_a(a.curve, a.curve.position), on_b(b.curve, b.curve.position);
    for (const double kept : {kNear, 1 - kNear}) {
      for (int j = 0; j < int(b.lines.size()); ++j) {
        const ClosestPoint near = on_a.closest(at(b.lines[j], level, kept));
        add(near.face, near.share[0], j, kept, length(b.lines[j], level));
      }
      for (int i = 0; i < int(a.lines.size()); ++i) {
        const ClosestPoint near = on_b.closest(at(a.lines[i], source, kept));
        add(i, kept, near.face, near.share[0], length(a.lines[i], source));
      }
    }
  }
  return found;
}

}  // namespace skinlod
