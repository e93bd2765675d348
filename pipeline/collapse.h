// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <concepts>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>
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
  // All that is asked of `pricing` is pure: calls run in parallel.
  // Of what `place` will cost, for much less work, when it did cost so much, or 0, before an end changed.
  { pricing.estimate(mesh, e, double()) } -> std::same_as<double>;
  { pricing.place(mesh, e) } -> std::same_as<typename M::Placement>;
  // A list of them: their midpoint, if the metric ever moves a point, then the kept end and the removed one,
  // both exactly as they are.
  { pricing.unsolved_places(mesh, e).front() } -> std::convertible_to<typename M::Placement>;
  { pricing.turns_a_face(mesh, e, p) } -> std::same_as<bool>;  // in a pose that the metric looks at
  { pricing.pose_count() } -> std::same_as<size_t>;            // how many poses a cost is the sum over
  // `e.kept` now stands for both ends. Calls for edges without a common end run in parallel.
  { metric.commit(e, p) } -> std::same_as<void>;
};

/// Called with the number of triangles left.
using TrianglesLeft = std::function<void(int)>;

/// One run of `collapse`, below.
template <CollapseMetric M>
class Collapsing {
 public:
  Collapsing(Mesh& mesh, M& metric)
      : mesh_(mesh),
        metric_(metric),
        stands_for_(mesh.position.size()),
        changed_(mesh.position.size(), 0),
        touched_(mesh.position.size(), 0) {
    std::iota(stands_for_.begin(), stands_for_.end(), 0);
  }

  History run(int target, const TrianglesLeft& tell) {
    for (size_t before = 0; mesh_.triangle_count() > target;) {
      before = history_.size();
      offers_.clear(), places_.clear(), unused_.clear();
      for (const Edge e : mesh_.edges()) offers_.push_back({0, 0, e, -1, true});
      estimate_changed();
      while (mesh_.triangle_count() > target && take_cheapest()) {
        solve();
        find_legal();
        carry_out(target, tell);
        renew_offers();
      }
      if (history_.size() == before) break;
    }
    return std::move(history_);
  }

 private:
  // One of so many offers is in a batch. Larger batches run ahead of what they change: with 32 the costs of a
  // history add up to 3 to 7 % more.
  static constexpr size_t kShare = 128;
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  // Every edge has one, always.
  struct Offer {
    double cost;    // what it stands in the order by; kNever until an end changes
    double solved;  // what it cost when last solved, or 0
    Edge edge;      // `kept` the lower
    int place;      // in places_; -1: not solved, the cost is an estimate
    bool changed;   // an end
    bool operator<(const Offer& o) const {
      return std::tie(cost, edge.kept, edge.removed) < std::tie(o.cost, o.edge.kept, o.edge.removed);
    }
  };

  void estimate_changed() {
    std::vector<Offer*> changed;
    for (Offer& offer : offers_) {
      if (std::exchange(offer.changed, false)) changed.push_back(&offer);
    }
    parallel_for(int(changed.size()), [&](int i) {
      Offer& offer = *changed[size_t(i)];
      offer.cost = metric_.estimate(mesh_, offer.edge, offer.solved);
    });
  }

  void drop_place(Offer& offer) {
    if (offer.place >= 0) unused_.push_back(std::exchange(offer.place, -1));
  }

  // Moves the cheapest offers to the batch, if there are any. The bar is what the cheapest of the others
  // costs.
  bool take_cheapest() {
    const size_t count = std::min(offers_.size(), 1 + offers_.size() / kShare);
    const auto others = offers_.end() - std::ptrdiff_t(count);
    const auto dearer = [](const Offer& a, const Offer& b) { return b < a; };
    bar_ = kNever;
    if (others != offers_.begin()) {
      std::nth_element(offers_.begin(), others - 1, offers_.end(), dearer);
      bar_ = (others - 1)->cost;
    }
    batch_.assign(others, offers_.end());
    offers_.erase(others, offers_.end());
    put_back([&](const Offer& offer) { return offer.cost == kNever; });
    return !batch_.empty();
  }

  void put_back(const auto& which) {
    std::erase_if(batch_, [&](const Offer& offer) {
      const bool back = which(offer);
      if (back) offers_.push_back(offer);
      return back;
    });
  }
  void put_back_dear() {
    put_back([&](const Offer& offer) { return offer.cost > bar_ || offer.cost == kNever; });
  }

  void solve() {
    std::vector<Offer*> unsolved;
    for (Offer& offer : batch_) {
      if (offer.place >= 0) continue;
      if (unused_.empty()) places_.emplace_back(), unused_.push_back(int(places_.size()) - 1);
      offer.place = unused_.back(), unused_.pop_back();
      unsolved.push_back(&offer);
    }
    parallel_for(int(unsolved.size()), [&](int i) {
      Offer& offer = *unsolved[size_t(i)];
      places_[offer.place] = place(offer.edge);
      offer.cost = offer.solved = places_[offer.place].cost;
    });
    put_back_dear();
  }

  // A locked end is the only place there is.
  typename M::Placement place(Edge e) const {
    const bool kept = mesh_.kind(e.kept) == Kind::Locked;
    if (!kept && mesh_.kind(e.removed) != Kind::Locked) return metric_.place(mesh_, e);
    const auto places = metric_.unsolved_places(mesh_, e);
    return *(places.end() - (kept ? 2 : 1));
  }

  // The edge or the edge turned, so that its seams continue if they do in either direction.
  std::optional<Edge> legal_direction(Edge edge) const {
    std::optional<Edge> legal;
    for (const Edge e : {edge, edge.turned()}) {
      if (mesh_.refusal(e) != Refusal::None) continue;
      if (!mesh_.stretches_a_chart(e)) return e;
      if (!legal) legal = e;
    }
    return legal;
  }

  void find_legal() {
    parallel_for(int(batch_.size()), [&](int i) {
      Offer& offer = batch_[size_t(i)];
      auto& place = places_[offer.place];
      const auto edge = legal_direction(offer.edge);
      const auto turns = [&](const auto& its) {
        return metric_.turns_a_face(mesh_, *edge, its) || mesh_.turns_a_uv(*edge, its.position);
      };
      if (!edge) {
        place.cost = kNever;
      } else if (turns(place)) {
        place.cost = kNever;
        if (mesh_.kind(edge->kept) != Kind::Locked) {
          for (const auto& other : metric_.unsolved_places(mesh_, *edge)) {
            if (other.cost < place.cost && !turns(other)) place = other;
          }
        }
      }
      offer.cost = place.cost;
      if (edge) offer.cost += double(metric_.pose_count()) * mesh_.stretch(*edge, place.position);
    });
    put_back_dear();
  }

  // What lies around an earlier collapse of the round must be looked at again, in the next.
  void carry_out(int target, const TrianglesLeft& tell) {
    ++round_;
    std::sort(batch_.begin(), batch_.end());
    std::vector<Offer> done;
    for (Offer& offer : batch_) {
      const bool touched = touched_[offer.edge.kept] == round_ || touched_[offer.edge.removed] == round_;
      const auto edge = touched ? std::nullopt : legal_direction(offer.edge);
      if (!edge || mesh_.triangle_count() <= target) {
        if (!touched && !edge) offer.cost = kNever;
        offers_.push_back(offer);
        continue;
      }
      const auto [kept, removed] = *edge;
      const auto ring = mesh_.neighbours(kept);
      for (const int v : mesh_.neighbours(removed)) {
        if (std::binary_search(ring.begin(), ring.end(), v)) merged_.emplace_back(std::minmax(removed, v));
      }
      mesh_.collapse(*edge, places_[offer.place].position, places_[offer.place].morphs);
      stands_for_[removed] = kept;
      changed_[kept] = changed_[removed] = round_;
      touched_[kept] = touched_[removed] = round_;
      for (const int v : mesh_.neighbours(kept)) touched_[v] = round_;
      offer.edge = *edge;
      done.push_back(offer);
      if (tell) tell(mesh_.triangle_count());
    }
    parallel_for(int(done.size()),
                 [&](int i) { metric_.commit(done[size_t(i)].edge, places_[done[size_t(i)].place]); });
    for (Offer& offer : done) {
      auto& place = places_[offer.place];
      history_.push_back(
          {offer.edge, place.cost, place.position, std::move(place.influences), std::move(place.morphs)});
      drop_place(offer);
    }
  }

  // Edges of removed vertices go over to the kept ones; where those have the edge too, there is only one.
  void renew_offers() {
    std::sort(merged_.begin(), merged_.end());
    for (Offer& offer : offers_) {
      auto& [kept, removed] = offer.edge;
      if (changed_[kept] != round_ && changed_[removed] != round_) continue;
      drop_place(offer);
      if (std::binary_search(merged_.begin(), merged_.end(), std::pair(kept, removed))) {
        kept = removed = -1;
      } else {
        offer.changed = true;
        std::tie(kept, removed) = std::minmax({stands_for_[kept], stands_for_[removed]});
      }
    }
    std::erase_if(offers_, [](const Offer& offer) { return offer.edge.kept < 0; });
    merged_.clear();
    estimate_changed();
  }

  Mesh& mesh_;
  M& metric_;
  History history_;
  std::vector<Offer> offers_, batch_;
  std::vector<typename M::Placement> places_;  // of the offers that are solved
  std::vector<int> unused_;                    // places of offers that are gone
  std::vector<int> stands_for_;                // per vertex: itself, or the one it was collapsed to
  std::vector<int> changed_, touched_;  // per vertex: the last round that collapsed an edge of its, beside it
  std::vector<std::pair<int, int>> merged_;  // edges of this round's removed vertices that fall on others
  int round_ = 0;
  double bar_ = 0;
};

/// Collapses edges of `mesh`, cheapest first, until at most `target` triangles remain or no edge may be
/// collapsed. Returns the collapses in order. The order depends on the input alone: ties go to the lower
/// vertices, and threads share out work whose results they do not order. An edge that is refused is offered
/// again when an end changes, and once no other is left: what is around it may have changed.
///
///   offer all edges, at estimates of their costs
///   until the target is reached or all offers once more change nothing:
///     take the cheapest few offers as a batch; solve those that are estimates, in parallel
///     put back what now costs more than the offers left behind
///     refuse what is illegal either way round; add what it costs that charts of texture stretch
///     where the solved place would turn a face over in a pose or in texture space
///       take the best of the unsolved places that would not, or refuse the edge
///     collapse what remains, in order, but for edges beside a collapse of the same batch
///     tell the metric, and offer the edges around the kept vertices anew, at estimates
template <CollapseMetric M>
History collapse(Mesh& mesh, M& metric, int target, const TrianglesLeft& tell = {}) {
  return Collapsing<M>(mesh, metric).run(target, tell);
}

}  // namespace skinlod
