// SPDX-License-Identifier: MIT
#pragma once

#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skinlod {

/// Seconds since some moment: of CPU time on all threads of the process, and by the clock on the wall.
double cpu_time();
double wall_time();

/// The most that the process has had in memory since the start, or since it was last told to forget that:
/// megabytes. 0 where the system does not tell, which is everywhere but on Linux.
double peak_megabytes();
void forget_peak();

/// What one stage of a cook took.
struct StageCost {
  std::string stage;
  double cpu_seconds = 0, wall_seconds = 0;
  double peak_megabytes = 0;  // of the whole process, what earlier stages left there with it
};

/// Notes where the time goes. It looks at the clock when another stage begins, and changes no result.
class StageClock {
 public:
  /// From here on it is `stage`.
  void operator()(std::string_view stage);

  /// All stages, in the order in which they began; the last one ends.
  std::vector<StageCost> stop();

 private:
  std::vector<StageCost> stages_;
  std::string now_;  // "": none
  double cpu_start_ = 0, wall_start_ = 0;
};

/// A line per stage, with a bar as long as its share of the time.
void print_stages(std::ostream& out, std::span<const StageCost> stages);

}  // namespace skinlod
