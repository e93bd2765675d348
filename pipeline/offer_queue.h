// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <tuple>
#include <vector>

namespace skinlod {

/// What an edge stands in the order by; ties go to the lower number.
struct OfferKey {
  double cost;
  int edge;
  bool operator>(const OfferKey& k) const { return std::tie(cost, edge) > std::tie(k.cost, k.edge); }
};

/// The cheapest first, many at a time: nothing is ever put in order. Each level has some of the cheapest of
/// the next, so that mostly few are looked at, which fit in a cache.
class OfferQueue {
 public:
  void clear() {
    for (auto& level : levels_) level.clear();
  }

  void push(const OfferKey& key) {
    size_t l = 0;
    while (l < kLast && (levels_[l].empty() || key > dearest_[l])) ++l;
    levels_[l].push_back(key);
  }

  bool empty() const {
    return std::ranges::all_of(levels_, [](const auto& level) { return level.empty(); });
  }

  /// Moves the `count` cheapest, or all there are, to the end of `taken`, in no order.
  void take(size_t count, std::vector<OfferKey>& taken) {
    while (count > 0 && !empty()) {
      if (levels_[0].empty()) draw(0);
      const size_t some = std::min(count, levels_[0].size());
      move_cheapest(some, levels_[0], taken);
      count -= some;
    }
  }

 private:
  static constexpr size_t kLast = 2;   // the level of all others
  static constexpr size_t kShare = 8;  // one of so many of a level goes to the one before it

  // Returns the dearest of them.
  static OfferKey move_cheapest(size_t count, std::vector<OfferKey>& from, std::vector<OfferKey>& to) {
    const auto first = from.end() - std::ptrdiff_t(count);
    std::nth_element(from.begin(), first, from.end(), std::greater());
    const OfferKey dearest = *first;
    to.insert(to.end(), first, from.end());
    from.erase(first, from.end());
    return dearest;
  }

  void draw(size_t level) {
    std::vector<OfferKey>& next = levels_[level + 1];
    if (next.empty()) draw(level + 1);
    dearest_[level] = move_cheapest(1 + next.size() / kShare, next, levels_[level]);
  }

  std::array<std::vector<OfferKey>, kLast + 1> levels_;
  std::array<OfferKey, kLast> dearest_{};  // no key of a level costs more, and all of later levels do
};

}  // namespace skinlod
