// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>
#include <vector>

namespace skinlod {

/// A list that is usually short: up to `N` items lie in the object itself, and only more of them take memory
/// from the heap. For what is asked about a vertex or an edge over and over.
template <class T, size_t N>
requires std::is_trivially_copyable_v<T>
class ShortList {
 public:
  using value_type = T;
  using const_reference = const T&;

  void push_back(const T& item) {
    if (size_ == N && more_.empty()) more_.assign(few_.begin(), few_.end());
    if (size_ < N) {
      few_[size_] = item;
    } else {
      more_.push_back(item);
    }
    ++size_;
  }

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T* data() const { return size_ <= N ? few_.data() : more_.data(); }
  T* data() { return size_ <= N ? few_.data() : more_.data(); }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T& operator[](size_t i) const { return data()[i]; }
  const T& front() const { return data()[0]; }

 private:
  std::array<T, N> few_;  // all items, while they fit
  std::vector<T> more_;   // else all of them
  size_t size_ = 0;
};

}  // namespace skinlod
