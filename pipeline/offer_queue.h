// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
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

/// The cheapest first. Only so many of the cheapest are a heap, which fits in a cache; the others lie in no
/// order until it is empty.
class OfferQueue {
 public:
  void clear() { near_.clear(), far_.clear(), last_ = {}; }

  void push(const OfferKey& key) {
    if (near_.empty() || key > last_) {
      far_.push_back(key);
    } else {
      near_.push_back(key);
      std::push_heap(near_.begin(), near_.end(), std::greater());
    }
  }

  bool empty() const { return near_.empty() && far_.empty(); }

  const OfferKey& front() {
    if (near_.empty()) draw_near();
    return near_.front();
  }

  OfferKey pop() {
    const OfferKey key = front();
    std::pop_heap(near_.begin(), near_.end(), std::greater());
    near_.pop_back();
    return key;
  }

 private:
  static constexpr int kShare = 8;  // one of so many is near

  void draw_near() {
    const auto first = far_.end() - std::ptrdiff_t(1 + far_.size() / kShare);
    std::nth_element(far_.begin(), first, far_.end(), std::greater());
    last_ = *first;
    near_.assign(first, far_.end());
    far_.erase(first, far_.end());
    std::make_heap(near_.begin(), near_.end(), std::greater());
  }

  std::vector<OfferKey> near_;  // a heap: none costs more than `last_`
  std::vector<OfferKey> far_;   // all cost more than what is near
  OfferKey last_{};
};

}  // namespace skinlod
