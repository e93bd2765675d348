// SPDX-License-Identifier: MIT
#include "pipeline/charts.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace skinlod {

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

std::map<int, int> chart_origins(const std::vector<int>& original, const std::vector<int>& level,
                                 std::span<const Pair> pairs) {
  std::map<std::pair<int, int>, double> shared;
  for (const Pair& pair : pairs) shared[{level[pair.level.face], original[pair.original.face]}] += pair.area;
  std::map<int, std::pair<double, int>> most;
  for (const auto& [both, area] : shared) {
    auto& best = most[both.first];
    if (area > best.first) best = {area, both.second};
  }
  std::map<int, int> origins;
  for (const auto& [chart, best] : most) origins[chart] = best.second;
  return origins;
}

std::vector<Pair> paired_in_charts(const Surface& original, const Surface& level) {
  std::vector<Pair> pairs = paired(original, level);
  const std::vector<int> theirs = charts(original), ours = charts(level);
  const std::map<int, int> origins = chart_origins(theirs, ours, pairs);
  std::erase_if(pairs, [&](const Pair& pair) {
    return theirs[pair.original.face] != origins.at(ours[pair.level.face]);
  });
  return pairs;
}

}  // namespace skinlod
