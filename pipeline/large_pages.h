// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace skinlod {

/// Memory for what takes megabytes, in large pages where the system lends them to whoever asks (Linux). Of
/// 225 thousand triangles in ten poses the first touch of small ones was a tenth of the cook, most of it on
/// one thread. Throws std::bad_alloc.
void* take_pages(size_t bytes);
void give_back_pages(void* pages, size_t bytes);

/// For vectors that may be so large. What is made by its number alone is left as `T` leaves it, unset where
/// it is numbers: the threads that set it are the first to touch it.
template <class T>
struct LargePages {
  using value_type = T;
  LargePages() = default;
  template <class U>
  LargePages(const LargePages<U>&) {}
  T* allocate(size_t count) {
    static_assert(alignof(T) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);
    return static_cast<T*>(take_pages(count * sizeof(T)));
  }
  void construct(T* item) { ::new (static_cast<void*>(item)) T; }
  template <class... Args>
  void construct(T* item, Args&&... args) {
    std::construct_at(item, std::forward<Args>(args)...);
  }
  void deallocate(T* items, size_t count) { give_back_pages(items, count * sizeof(T)); }
  friend bool operator==(LargePages, LargePages) { return true; }
};

template <class T>
using LargeVector = std::vector<T, LargePages<T>>;

}  // namespace skinlod
