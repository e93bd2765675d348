// SPDX-License-Identifier: MIT
#include "tools/stage_clock.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <utility>

#include "tools/table.h"
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace skinlod {

double cpu_time() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double wall_time() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double peak_megabytes() {
  std::ifstream status("/proc/self/status");
  double kilobytes = 0;
  for (std::string word; status >> word;) {
    if (word == "VmHWM:") status >> kilobytes;
  }
  return kilobytes / 1024;
}

// Linux keeps the peak, and forgets it for a 5.
void forget_peak() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
  std::ofstream("/proc/self/clear_refs") << 5;
}

void StageClock::operator()(std::string_view stage) {
  if (stage == now_) return;
  const double cpu = cpu_time(), wall = wall_time();
  if (!now_.empty()) stages_.push_back({now_, cpu - cpu_start_, wall - wall_start_, peak_megabytes()});
  forget_peak();
  now_ = stage, cpu_start_ = cpu, wall_start_ = wall;
}

std::vector<StageCost> StageClock::stop() {
  (*this)("");
  return std::move(stages_);
}

void print_stages(std::ostream& out, std::span<const StageCost> stages) {
  StageCost all{"all", 0, 0, 0};
  for (const StageCost& s : stages) {
    all.cpu_seconds += s.cpu_seconds, all.wall_seconds += s.wall_seconds;
    all.peak_megabytes = std::max(all.peak_megabytes, s.peak_megabytes);
  }
  constexpr double kWidth = 30;
  std::vector<std::vector<std::string>> rows = {{"stage", "seconds", "CPU seconds", "peak MB", ""}};
  const auto add = [&](const StageCost& s, double share) {
    const std::string bar(size_t(std::lround(kWidth * share)), '#');
    rows.push_back({s.stage, rounded(s.wall_seconds), rounded(s.cpu_seconds),
                    s.peak_megabytes > 0 ? grouped(std::lround(s.peak_megabytes)) : "-",
                    bar + std::string(size_t(kWidth) - bar.size(), ' ')});
  };
  for (const StageCost& s : stages) add(s, all.wall_seconds > 0 ? s.wall_seconds / all.wall_seconds : 0);
  add(all, 0);
  print_table(out, rows);
}

}  // namespace skinlod
