// SPDX-License-Identifier: MIT
#include "tests/bench/clock.h"

#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>
#include <vector>

#include "pipeline/parallel.h"

namespace skinlod {
namespace {

double user_time() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_utime.tv_sec) + 1e-6 * double(usage.ru_utime.tv_usec);
}

double wall_time() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Linux keeps the peak, and forgets it for a 5. Elsewhere there is none to tell.
void forget_peak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << 5;
}

double peak_megabytes() {
  std::ifstream status("/proc/self/status");
  double kilobytes = 0;
  for (std::string word; status >> word;) {
    if (word == "VmHWM:") status >> kilobytes;
  }
  return kilobytes / 1024;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Cost cost_of(int runs, const std::function<void()>& work, int threads) {
  constexpr double kLeast = 0.05;
  const ThreadLimit limit(threads);
  std::vector<double> user, wall;
  forget_peak();
  for (int run = 0; run < runs; ++run) {
    const double user_start = user_time(), wall_start = wall_time();
    double spent = 0;
    int calls = 0;
    for (; spent < kLeast; ++calls) work(), spent = user_time() - user_start;
    user.push_back(spent / calls), wall.push_back((wall_time() - wall_start) / calls);
  }
  return {median(user), median(wall), peak_megabytes()};
}

}  // namespace skinlod
