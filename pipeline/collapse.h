// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <concepts>
#include <functional>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "pipeline/history.h"
#include "pipeline/mesh.h"
#include "pipeline/offer_queue.h"
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
        offers_(size_t(mesh.edge_slots())),
        claimed_(mesh.position.size(), 0),
        touched_(mesh.position.size(), 0) {}

  History run(int target, const TrianglesLeft& tell) {
    for (size_t before = 0; mesh_.triangle_count() > target;) {
      before = history_.size();
      offer_all();
      while (mesh_.triangle_count() > target && take_cheapest()) {
        solve();
        find_legal();
        carry_out(target, tell);
      }
      if (history_.size() == before) break;
    }
    return std::move(history_);
  }

 private:
  // One of so many edges is in a batch. Larger batches run ahead of what they change: with 32 the costs of a
  // history add up to 3 to 7 % more.
  static constexpr int kShare = 128;
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  // Every edge of the mesh has one. It is in the queue, in the batch, or refused until an end changes.
  struct Offer {
    double cost = 0;      // what it stands in the order by; kNever where it is refused
    double solved = 0;    // what it cost when last solved, or 0
    int place = -1;       // in places_; -1: not solved, the cost is an estimate
    bool changed = true;  // an end, since: the cost is of before, and costs hardly ever fall
  };
  struct Candidate {
    double cost;
    int number;
    Edge edge;  // the way round in which it may be collapsed
    bool operator<(const Candidate& c) const { return std::tie(cost, number) < std::tie(c.cost, c.number); }
  };

  void offer_all() {
    queue_.clear(), places_.clear(), unused_.clear();
    std::vector<int> there;
    for (int e = 0; e < mesh_.edge_slots(); ++e) {
      offers_[e] = {};
      if (mesh_.edge(e).kept >= 0) there.push_back(e);
    }
    parallel_for(int(there.size()), [&](int i) { estimate(there[size_t(i)]); });
    for (const int e : there) push(e);
  }

  void estimate(int edge) {
    Offer& offer = offers_[edge];
    offer.cost = metric_.estimate(mesh_, mesh_.edge(edge), offer.solved);
    offer.changed = false;
  }

  void push(int edge) { queue_.push({offers_[edge].cost, edge}); }

  void drop_place(Offer& offer) {
    if (offer.place >= 0) unused_.push_back(std::exchange(offer.place, -1));
  }

  // Moves the cheapest offers to the batch; false where there are none. The bar is what the cheapest of the
  // others costs.
  bool take_cheapest() {
    ++round_;
    const auto count = size_t(1 + mesh_.edge_count() / kShare);
    // One more, which is the cheapest of those left behind.
    std::vector<OfferKey> taken;
    while (taken.size() <= count && !queue_.empty()) {
      queue_.take(count + 1 - taken.size(), taken);
      std::erase_if(taken, [&](const OfferKey& key) { return mesh_.edge(key.edge).kept < 0; });
    }
    if (taken.empty()) return false;
    bar_ = kNever;
    if (taken.size() > count) {
      const auto dearest = std::ranges::min_element(taken, std::greater());
      bar_ = dearest->cost, queue_.push(*dearest);
      taken.erase(dearest);
    }
    batch_.clear();
    for (const auto& [cost, edge] : taken) batch_.push_back({cost, edge, mesh_.edge(edge)});
    parallel_for(int(batch_.size()), [&](int i) {
      if (offers_[batch_[size_t(i)].number].changed) estimate(batch_[size_t(i)].number);
    });
    put_back_dear();
    // Of those that share an end one can be collapsed, seldom not the cheapest.
    std::sort(batch_.begin(), batch_.end());
    put_back([&](const Candidate& c) {
      const bool other = claimed_[c.edge.kept] == round_ || claimed_[c.edge.removed] == round_;
      if (!other) claimed_[c.edge.kept] = claimed_[c.edge.removed] = round_;
      return other;
    });
    return true;
  }

  void put_back(const auto& which) {
    size_t left = 0;
    for (Candidate& candidate : batch_) {
      candidate.cost = offers_[candidate.number].cost;
      if (candidate.cost == kNever) continue;
      if (which(candidate)) {
        push(candidate.number);
      } else {
        batch_[left++] = candidate;
      }
    }
    batch_.resize(left);
  }
  void put_back_dear() {
    put_back([&](const Candidate& candidate) { return candidate.cost > bar_; });
  }

  void solve() {
    std::vector<int> unsolved;
    for (const Candidate& candidate : batch_) {
      Offer& offer = offers_[candidate.number];
      if (offer.place >= 0) continue;
      if (unused_.empty()) places_.emplace_back(), unused_.push_back(int(places_.size()) - 1);
      offer.place = unused_.back(), unused_.pop_back();
      unsolved.push_back(candidate.number);
    }
    parallel_for(int(unsolved.size()), [&](int i) {
      Offer& offer = offers_[unsolved[size_t(i)]];
      places_[offer.place] = place(mesh_.edge(unsolved[size_t(i)]));
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
  struct Direction {
    Edge edge;
    bool stretches;  // a chart
  };
  std::optional<Direction> legal_direction(Edge edge) const {
    std::optional<Direction> legal;
    for (const Edge e : {edge, edge.turned()}) {
      if (mesh_.refusal(e) != Refusal::None) continue;
      if (!mesh_.stretches_a_chart(e)) return Direction{e, false};
      if (!legal) legal = {e, true};
    }
    return legal;
  }

  void find_legal() {
    parallel_for(int(batch_.size()), [&](int i) {
      Candidate& candidate = batch_[size_t(i)];
      Offer& offer = offers_[candidate.number];
      auto& place = places_[offer.place];
      const auto legal = legal_direction(candidate.edge);
      const Edge edge = candidate.edge = legal ? legal->edge : candidate.edge;
      const auto turns = [&](const auto& its) {
        return mesh_.turns_from_source(edge, its.position) || metric_.turns_a_face(mesh_, edge, its) ||
               mesh_.turns_a_uv(edge, its.position);
      };
      if (!legal) {
        place.cost = kNever;
      } else if (turns(place)) {
        place.cost = kNever;
        if (mesh_.kind(edge.kept) != Kind::Locked) {
          for (const auto& other : metric_.unsolved_places(mesh_, edge)) {
            if (other.cost < place.cost && !turns(other)) place = other;
          }
        }
      }
      offer.cost = place.cost;
      if (legal && legal->stretches)
        offer.cost += double(metric_.pose_count()) * mesh_.stretch(edge, place.position);
    });
    put_back_dear();
  }

  // What lies around an earlier collapse of the round must be looked at again, in the next.
  void carry_out(int target, const TrianglesLeft& tell) {
    std::sort(batch_.begin(), batch_.end());
    std::vector<Candidate> done;
    std::vector<Mesh::Joined> joined;
    for (const Candidate& candidate : batch_) {
      const auto& [cost, number, edge] = candidate;
      const bool touched = touched_[edge.kept] == round_ || touched_[edge.removed] == round_;
      if (touched || mesh_.triangle_count() <= target) {
        push(number);
      } else if (mesh_.strands_a_vertex(edge)) {
        offers_[number].cost = kNever;
      } else {
        touch(edge.kept), touch(edge.removed);
        joined.push_back(mesh_.join(edge, places_[offers_[number].place].position));
        for (const int e : mesh_.edges_around(edge.kept)) change(e);
        done.push_back(candidate);
        if (tell) tell(mesh_.triangle_count());
      }
    }
    const auto place_of = [&](const Candidate& c) -> auto& { return places_[offers_[c.number].place]; };
    parallel_for(int(done.size()), [&](int i) {
      const auto& place = place_of(done[size_t(i)]);
      mesh_.blend(joined[size_t(i)], place.morphs);
      metric_.commit(done[size_t(i)].edge, place);
    });
    for (const Candidate& candidate : done) {
      auto& place = place_of(candidate);
      history_.push_back(
          {candidate.edge, place.cost, place.position, std::move(place.influences), std::move(place.morphs)});
      drop_place(offers_[candidate.number]);
    }
  }

  void touch(int vertex) {
    for (const int f : mesh_.faces_around(vertex)) {
      for (const int v : mesh_.face(f)) touched_[v] = round_;
    }
  }

  // An end of the edge has changed.
  void change(int edge) {
    Offer& offer = offers_[edge];
    drop_place(offer);
    offer.changed = true;
    if (offer.cost == kNever) offer.cost = offer.solved, push(edge);
  }

  Mesh& mesh_;
  M& metric_;
  History history_;
  std::vector<Offer> offers_;  // per edge of the mesh
  OfferQueue queue_;
  std::vector<Candidate> batch_;
  std::vector<typename M::Placement> places_;  // of the offers that are solved
  std::vector<int> unused_;                    // places of offers that are gone
  std::vector<int> claimed_,
      touched_;  // per vertex: the last round that had an edge of its, or collapsed one beside it
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
///     take the cheapest few offers as a batch, of those that share an end the cheapest
///     estimate anew those with an end that has changed, and solve those that are estimates, in parallel
///     put back what now costs more than the offers left behind
///     refuse what is illegal either way round; add what it costs that charts of texture stretch
///     where the solved place would turn a face over in a pose or in texture space, or from the source
///       take the best of the unsolved places that would not, or refuse the edge
///     collapse what remains, in order, but for edges beside a collapse of the same batch
///     tell the metric; the edges around the kept vertices keep their place in the order until it comes
template <CollapseMetric M>
History collapse(Mesh& mesh, M& metric, int target, const TrianglesLeft& tell = {}) {
  return Collapsing<M>(mesh, metric).run(target, tell);
}

}  // namespace skinlod
