// SPDX-License-Identifier: MIT
#include "pipeline/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

namespace skinlod {

void parallel_for(int count, const std::function<void(int)>& body) {
  tbb::parallel_for(0, count, [&](int i) { body(i); });
}

void in_parallel(std::initializer_list<std::function<void()>> tasks) {
  parallel_for(int(tasks.size()), [&](int i) { tasks.begin()[i](); });
}

struct ThreadLimit::Control {
  tbb::global_control control;
};

ThreadLimit::ThreadLimit(int count) {
  if (count > 0) control_.reset(new Control{{tbb::global_control::max_allowed_parallelism, size_t(count)}});
}

ThreadLimit::~ThreadLimit() = default;

}  // namespace skinlod
