// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <type_traits>
#include <utility>
#include <vector>

namespace skinlod {

/// A list that is usually short: up to `N` items lie in the object itself, and only more of them take memory
/// from the heap. For what is asked about a vertex or an edge over and over. Otherwise it is a std::vector,
/// but that items move with the object they lie in.
template <class T, size_t N>
requires std::is_trivially_copyable_v<T>
class ShortList {
 public:
  using value_type = T;
  using const_reference = const T&;
  using iterator = T*;
  using const_iterator = const T*;

  ShortList() = default;
  ShortList(const ShortList&) = default;
  ShortList& operator=(const ShortList&) = default;
  ShortList(ShortList&& from) noexcept { *this = std::move(from); }
  ShortList& operator=(ShortList&& from) noexcept {
    if (this == &from) return *this;
    few_ = from.few_, more_ = std::move(from.more_), size_ = std::exchange(from.size_, 0);
    return *this;
  }
  ShortList(std::initializer_list<T> items) : ShortList(items.begin(), items.end()) {}
  ShortList(std::input_iterator auto first, std::input_iterator auto last) {
    for (; first != last; ++first) push_back(*first);
  }

  void push_back(const T& item) {
    if (size_ == N && more_.empty()) more_.assign(few_.begin(), few_.end());
    if (size_ < N) {
      few_[size_] = item;
    } else {
      more_.push_back(item);
    }
    ++size_;
  }

  T& emplace_back(const auto&... parts) {
    push_back(T{parts...});
    return back();
  }

  void resize(size_t size) {
    while (size_ < size) push_back({});
    if (size_ > N && size <= N) std::copy_n(more_.begin(), size, few_.begin()), more_.clear();
    if (size > N) more_.resize(size);
    size_ = size;
  }
  void clear() { resize(0); }
  void reserve(size_t size) {
    if (size > N) more_.reserve(size);
  }
  iterator insert(const_iterator before, const T& item) {
    const auto at = before - begin();
    push_back(item);
    std::rotate(begin() + at, end() - 1, end());
    return begin() + at;
  }
  iterator erase(const_iterator first, const_iterator last) {
    const auto at = first - begin(), count = last - first;
    if (count > 0) std::copy(begin() + at + count, end(), begin() + at);
    resize(size_ - size_t(count));
    return begin() + at;
  }
  iterator erase(const_iterator item) { return erase(item, item + 1); }

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T* data() const { return size_ <= N ? few_.data() : more_.data(); }
  T* data() { return size_ <= N ? few_.data() : more_.data(); }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T& operator[](size_t i) const { return data()[i]; }
  T& operator[](size_t i) { return data()[i]; }
  const T& front() const { return data()[0]; }
  T& front() { return data()[0]; }
  const T& back() const { return data()[size_ - 1]; }
  T& back() { return data()[size_ - 1]; }

  friend bool operator==(const ShortList& a, const ShortList& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }
  friend size_t erase_if(ShortList& list, const auto& which) {
    const auto kept = std::remove_if(list.begin(), list.end(), which);
    const auto count = size_t(list.end() - kept);
    list.resize(list.size() - count);
    return count;
  }

 private:
  std::array<T, N> few_;  // all items, while they fit
  std::vector<T> more_;   // else all of them
  size_t size_ = 0;
};

}  // namespace skinlod
