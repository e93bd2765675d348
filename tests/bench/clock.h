// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

namespace skinlod {

/// What one call of some work takes.
struct Cost {
  double cpu_seconds = 0;  // of CPU time, on all threads together
  double wall_seconds = 0;
  double peak_megabytes = 0;  // resident in the whole process, what was there before with it
};

/// The cost of one call of `work` on so many threads: of `runs` the median of each time, and the largest
/// peak. What takes less than 50 ms is called again and again for as long, since the clock does not tell
/// less.
Cost cost_of(int runs, const std::function<void()>& work, int threads = 1);

}  // namespace skinlod
