// SPDX-License-Identifier: MIT
#include "pipeline/parallel.h"

#include <algorithm>

#ifdef SKINLOD_PLAIN_THREADS
#include <exception>
#include <thread>
#else
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#endif

namespace skinlod {

#ifdef SKINLOD_PLAIN_THREADS

// For ThreadSanitizer, which does not see how TBB hands work from one thread to another: two for every loop,
// each with half of the calls, however few there are and whatever the limit. Only that they join orders them.
void parallel_for(int count, const std::function<void(int)>& body) {
  std::exception_ptr thrown;
  const auto work = [&](int first) {
    for (int i = first; i < count; i += 2) body(i);
  };
  {
    const std::jthread other([&] {
      try {
        work(1);
      } catch (...) {
        thrown = std::current_exception();
      }
    });
    work(0);
  }
  if (thrown) std::rethrow_exception(thrown);
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
