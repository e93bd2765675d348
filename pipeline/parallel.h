// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <initializer_list>
#include <memory>

namespace skinlod {

/// Calls `body(i)` once for each i in 0 .. count - 1, on all threads the process may use. Calls must not
/// touch each other's results; nothing may depend on their order.
void parallel_for(int count, const std::function<void(int)>& body);

/// Calls `body(begin, end)` once for every `kRun` of the items 0 .. `count` - 1 that follow each other, and
/// for the rest of them, under the same terms: for items too small for a call each.
inline constexpr size_t kRun = 1024;
void for_each_run(size_t count, const std::function<void(size_t begin, size_t end)>& body);

/// Calls each of the tasks once, under the same terms.
void in_parallel(std::initializer_list<std::function<void()>> tasks);

/// While it lives the process may use at most `count` threads; 0: all there are.
class ThreadLimit {
 public:
  explicit ThreadLimit(int count);
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;
  ~ThreadLimit();

 private:
  struct Control;
  std::unique_ptr<Control> control_;  // null where there is no limit
};

}  // namespace skinlod
