// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <functional>
#include <optional>
#include <queue>
#include <tuple>
#include <vector>

#include "pipeline/history.h"
#include "pipeline/mesh.h"
#include "pipeline/parallel.h"

namespace skinlod {

/// A metric prices collapses and keeps its own per-vertex books.
template <class M>
concept CollapseMetric = requires(M metric, const M& pricing, const Mesh& mesh, Edge e,
                                  typename M::Placement p) {
  requires std::derived_from<typename M::Placement, Placement>;
  { pricing.place(mesh, e) } -> std::same_as<typename M::Placement>;  // pure: calls may run in parallel
  // A list of them: the ends and, if the metric ever moves a point, their midpoint.
  { pricing.unsolved_places(mesh, e).front() } -> std::convertible_to<typename M::Placement>;
  { pricing.turns_a_face(mesh, e, p) } -> std::same_as<bool>;  // in a pose that the metric looks at
  { metric.commit(e, p) } -> std::same_as<void>;               // `e.kept` now stands for both ends
};

/// Called with the number of triangles left.
using TrianglesLeft = std::function<void(int)>;

/// Collapses edges of `mesh`, cheapest first, until at most `target` triangles remain or no edge may be
/// collapsed. Returns the collapses in order. The order depends on the input alone: ties go to the lower
/// vertices. An edge that is refused is offered again when an end changes, and once the queue is empty: what
/// is around it may have changed.
///
///   price all edges
///   until the target is reached or a whole round changes nothing:
///     take the cheapest offer; skip it if an end has changed since
///     turn the edge so that its seams continue; skip it if it is illegal
///     if the solved place would turn a face over, offer the edge again at the best of its unsolved places
///     that would not; skip it if all would collapse, tell the metric, price the edges around the
///     kept vertex anew
template <CollapseMetric M>
History collapse(Mesh& mesh, M& metric, int target, const TrianglesLeft& tell = {}) {
  struct Offer {
    double cost;
    Edge edge;
    std::uint32_t stamp;  // sum of the two ends' versions when the offer was priced
    bool solved;          // at the solved place; else at the best of the unsolved ones
    bool operator>(const Offer& o) const {
      return std::tie(cost, edge.kept, edge.removed) > std::tie(o.cost, o.edge.kept, o.edge.removed);
    }
  };
  std::priority_queue<Offer, std::vector<Offer>, std::greater<>> offers;
  std::vector<std::uint32_t> version(mesh.position.size(), 0);
  const auto stamp = [&](Edge e) { return version[e.kept] + version[e.removed]; };
  const auto price = [&](const std::vector<Edge>& edges) {
    std::vector<double> cost(edges.size());
    const auto one = [&](int i) { cost[i] = metric.place(mesh, edges[i]).cost; };
    if (edges.size() > 64) {
      parallel_for(int(edges.size()), one);
    } else {
      for (int i = 0; i < int(edges.size()); ++i) one(i);
    }
    for (size_t i = 0; i < edges.size(); ++i) offers.push({cost[i], edges[i], stamp(edges[i]), true});
  };
  const auto find_place = [&](Edge edge, bool solved) -> std::optional<typename M::Placement> {
    std::optional<typename M::Placement> best;
    const auto consider = [&](const typename M::Placement& place) {
      if ((!best || place.cost < best->cost) && !metric.turns_a_face(mesh, edge, place)) best = place;
    };
    if (solved) {
      consider(metric.place(mesh, edge));
    } else {
      for (const auto& place : metric.unsolved_places(mesh, edge)) consider(place);
    }
    return best;
  };

  History history;
  for (size_t before = 0; mesh.triangle_count() > target;) {
    before = history.size();
    price(mesh.edges());
    while (mesh.triangle_count() > target && !offers.empty()) {
      const Offer best = offers.top();
      offers.pop();
      if (best.stamp != stamp(best.edge)) continue;  // an end has changed; a newer offer is in the queue
      Edge edge = best.edge;
      if (mesh.refusal(edge) != Refusal::None) edge = edge.turned();
      if (mesh.refusal(edge) != Refusal::None) continue;
      const auto placement = find_place(edge, best.solved);
      if (!placement) {
        const auto other = best.solved ? find_place(edge, false) : std::nullopt;
        if (other) offers.push({other->cost, best.edge, best.stamp, false});
        continue;
      }
      mesh.collapse(edge, placement->position);
      metric.commit(edge, *placement);
      history.push_back({edge, placement->cost, placement->position, placement->influences});

      ++version[edge.kept], ++version[edge.removed];
      std::vector<Edge> around;
      for (const int v : mesh.neighbours(edge.kept))
        around.push_back({std::min(edge.kept, v), std::max(edge.kept, v)});
      price(around);
      if (tell) tell(mesh.triangle_count());
    }
    if (history.size() == before) break;
  }
  return history;
}

}  // namespace skinlod
