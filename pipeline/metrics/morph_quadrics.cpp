// SPDX-License-Identifier: MIT
#include "pipeline/metrics/morph_quadrics.h"

#include <algorithm>

#include "pipeline/metrics/surface_quadrics.h"
#include "pipeline/morphs.h"
#include "pipeline/parallel.h"
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

// Per morph, the vertices that it moves and those that have a face in common with one, ascending.
std::vector<std::vector<int>> touched_vertices(const Mesh& mesh, int morphs) {
  std::vector<std::vector<int>> touched;
  touched.resize(size_t(morphs));
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    std::vector<int> near;
    for (const int f : mesh.faces_around(v))
      near.insert(near.end(), mesh.face(f).begin(), mesh.face(f).end());
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    for (const MorphOffset& m : mesh.morphs(v))
      touched[m.morph].insert(touched[m.morph].end(), near.begin(), near.end());
  }
  for (std::vector<int>& vertices : touched) {
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  }
  return touched;
}

}  // namespace

MorphQuadrics::MorphQuadrics(const Mesh& mesh) {
  const int morphs = morph_count(mesh);
  if (morphs == 0) return;
  const std::vector<HeldLine> lines = held_lines(mesh);
  rest_ = surface_quadrics(mesh, mesh.position, lines);
  of_.resize(rest_.size());
  const auto touched = touched_vertices(mesh, morphs);
  for (int m = 0; m < morphs; ++m) {
    for (const int v : touched[m]) of_[v].push_back({m, {}});
  }
  parallel_for(morphs, [&](int m) {
    std::vector<Vec3> points = mesh.position;
    for (const int v : touched[m]) points[v] += offset_of(mesh.morphs(v), m);
    const std::vector<Quadric> quadrics = surface_quadrics(mesh, points, lines);
    for (const int v : touched[m]) std::ranges::lower_bound(of_[v], m, {}, &Entry::morph)->q = quadrics[v];
  });
}

void MorphQuadrics::for_each_sum(Edge e, const auto& take) const {
  if (of_.empty()) return;
  const auto morph = [](const Entry& entry) { return entry.morph; };
  side_by_side(of_[e.kept], of_[e.removed], morph, [&](const Entry* a, const Entry* b) {
    take(a ? a->morph : b->morph, (a ? a->q : rest_[e.kept]) + (b ? b->q : rest_[e.removed]));
  });
}

std::array<MorphQuadrics::Cost, 2> MorphQuadrics::at_ends(const Mesh& mesh, Edge e) const {
  std::array<Cost, 2> cost;
  for_each_sum(e, [&](int morph, const Quadric& q) {
    for (size_t end = 0; end < 2; ++end) {
      const int v = end == 0 ? e.kept : e.removed;
      cost[end].sum += std::max(0.0, q(mesh.position[v] + offset_of(mesh.morphs(v), morph)));
      ++cost[end].poses;
    }
  });
  return cost;
}

MorphQuadrics::Cost MorphQuadrics::solve(const Mesh& mesh, Edge e, Placement& to) const {
  Cost cost = blend(mesh, e, to);
  if (cost.poses == 0) return cost;
  const MorphOffsets start = std::move(*to.morphs);
  const Vec3 bind = minimum(rest_[e.kept] + rest_[e.removed], to.position);
  cost.sum = 0;
  to.morphs->clear();
  for_each_sum(e, [&](int morph, const Quadric& q) {
    const Vec3 delta = minimum(q, bind + offset_of(start, morph)) - bind;
    cost.sum += std::max(0.0, q(to.position + delta));
    if (!delta.isZero(0)) to.morphs->push_back({morph, delta});
  });
  return cost;
}

MorphQuadrics::Cost MorphQuadrics::blend(const Mesh& mesh, Edge e, Placement& to) const {
  Cost cost;
  if (of_.empty()) return cost;
  to.morphs = skinlod::blend(mesh.morphs(e.kept), mesh.morphs(e.removed), mesh.way_along(e, to.position));
  for_each_sum(e, [&](int morph, const Quadric& q) {
    cost.sum += std::max(0.0, q(to.position + offset_of(*to.morphs, morph)));
    ++cost.poses;
  });
  return cost;
}

bool MorphQuadrics::turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const {
  if (of_.empty()) return false;
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
  if (of_.empty()) return;
  std::vector<Entry> sum;
  for_each_sum(e, [&](int morph, const Quadric& q) { sum.push_back({morph, q}); });
  of_[e.kept] = std::move(sum);
  of_[e.removed] = {};
  rest_[e.kept] += rest_[e.removed];
}

}  // namespace skinlod
