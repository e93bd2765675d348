// SPDX-License-Identifier: MIT
#include "tests/bench/clock.h"

#include <algorithm>
#include <vector>

#include "pipeline/parallel.h"
#include "tools/stage_clock.h"

namespace skinlod {
namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Cost cost_of(int runs, const std::function<void()>& work, int threads) {
  constexpr double kLeast = 0.05;
  const ThreadLimit limit(threads);
  std::vector<double> cpu, wall;
  forget_peak();
  for (int run = 0; run < runs; ++run) {
    const double cpu_start = cpu_time(), wall_start = wall_time();
    double spent = 0;
    int calls = 0;
    for (; spent < kLeast; ++calls) work(), spent = cpu_time() - cpu_start;
    cpu.push_back(spent / calls), wall.push_back((wall_time() - wall_start) / calls);
  }
  return {median(cpu), median(wall), peak_megabytes()};
}

}  // namespace skinlod
