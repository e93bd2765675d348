// SPDX-License-Identifier: MIT
#include "pipeline/charts.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace skinlod {
std::vector<int> grouped(const Surface& s, int from, int to, bool by_part) {
  const auto agree = [&](int a, int b) {
    return (!by_part || s.wedges[a].part == s.wedges[b].part) &&
           s.attributes.row(a).segment(from, to - from) == s.attributes.row(b).segment(from, to - from);
  };
  // Per vertex, the wedges that are the first of their groups, as a linked list.
  std::vector<int> first(s.position.size(), -1), next(s.wedges.size(), -1), group;
  int count = 0;
  for (int w = 0; w < int(s.wedges.size()); ++w) {
    int* other = &first[s.wedges[w].vertex];
    while (*other >= 0 && !agree(*other, w)) other = &next[*other];
    if (*other < 0) *other = w;
    group.push_back(*other < w ? group[*other] : count++);
  }
  return group;
}

std::vector<int> sheets(const Surface& s) {
  return grouped(s, s.layout.uv_at(0), s.layout.uv_at(s.layout.uv_sets), true);
}

std::vector<int> charts(const Surface& s) {
  const std::vector<int> sheet = sheets(s);
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

std::vector<SeamLine> seam_lines(const Surface& s, const Neighbourhood& faces) {
  const std::vector<int> sheet = sheets(s);
  const auto sheet_at = [&](int f, int v) {
    const auto& its = faces.vertices(f);
    return sheet[s.face(f)[size_t(std::find(its.begin(), its.end(), v) - its.begin())]];
  };
  const auto is_seam = [&](const SeamLine& line) {
    const int f = line.faces[0], g = line.faces[1];
    const auto &a = faces.vertices(f), &b = faces.vertices(g);
    const auto in_a = [&](int v) { return std::find(a.begin(), a.end(), v) != a.end(); };
    const auto parts_at = [&](int v) { return sheet_at(f, v) != sheet_at(g, v); };
    return !std::all_of(b.begin(), b.end(), in_a) &&  // else they are the two sides of a card
           (parts_at(line.edge.kept) || parts_at(line.edge.removed));
  };
  std::vector<SeamLine> lines;
  std::vector<std::pair<int, int>> sides;  // an edge's other end, and a face that has it
  for (int v = 0; v < faces.vertex_count(); ++v) {
    sides.clear();
    for (const int f : faces.faces_around(v)) {
      for (const int to : faces.vertices(f)) {
        if (to > v) sides.emplace_back(to, f);
      }
    }
    std::sort(sides.begin(), sides.end());
    for (size_t i = 0, end = 0; i < sides.size(); i = end) {
      while (end < sides.size() && sides[end].first == sides[i].first) ++end;
      const SeamLine line{{v, sides[i].first}, {sides[i].second, sides[end - 1].second}};
      if (end - i == 2 && is_seam(line)) lines.push_back(line);
    }
  }
  return lines;
}

}  // namespace skinlod
