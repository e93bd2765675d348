// SPDX-License-Identifier: MIT
#include "pipeline/parallel.h"

#include <algorithm>

#ifdef SKINLOD_PLAIN_THREADS
#include <atomic>
#include <thread>
#else
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#endif

namespace skinlod {

#ifdef SKINLOD_PLAIN_THREADS

// For ThreadSanitizer, which does not see how TBB hands work from one thread to another: two for every loop.
// Between their calls nothing is ordered.
void parallel_for(int count, const std::function<void(int)>& body) {
  std::atomic<int> next = 0;
  const auto take = [&] { return next.fetch_add(1, std::memory_order_relaxed); };
  const auto work = [&] {
    for (int i = take(); i < count; i = take()) body(i);
  };
  const std::jthread other(work);
  work();
}

struct ThreadLimit::Control {};

ThreadLimit::ThreadLimit(int) {}

#else

void parallel_for(int count, const std::function<void(int)>& body) {
  tbb::parallel_for(0, count, [&](int i) { body(i); });
}

struct ThreadLimit::Control {
  tbb::global_control control;
};

ThreadLimit::ThreadLimit(int count) {
  if (count > 0) control_.reset(new Control{{tbb::global_control::max_allowed_parallelism, size_t(count)}});
}

#endif

ThreadLimit::~ThreadLimit() = default;

void for_each_run(size_t count, const std::function<void(size_t begin, size_t end)>& body) {
  parallel_for(int((count + kRun - 1) / kRun),
               [&](int run) { body(size_t(run) * kRun, std::min(size_t(run + 1) * kRun, count)); });
}

void in_parallel(std::initializer_list<std::function<void()>> tasks) {
  parallel_for(int(tasks.size()), [&](int i) { tasks.begin()[i](); });
}

}  // namespace skinlod
