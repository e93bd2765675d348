// SPDX-License-Identifier: MIT
#include "tests/bench/clock.h"

#include <sys/resource.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <vector>

namespace skinlod {
namespace {

double user_time() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_utime.tv_sec) + 1e-6 * double(usage.ru_utime.tv_usec);
}

}  // namespace

double user_seconds(int runs, const std::function<void()>& work) {
  constexpr double kLeast = 0.05;
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<double> seconds;
  for (int run = 0; run < runs; ++run) {
    const double start = user_time();
    double spent = 0;
    int calls = 0;
    for (; spent < kLeast; ++calls) work(), spent = user_time() - start;
    seconds.push_back(spent / calls);
  }
  std::nth_element(seconds.begin(), seconds.begin() + runs / 2, seconds.end());
  return seconds[size_t(runs / 2)];
}

}  // namespace skinlod
