// SPDX-License-Identifier: MIT
#include "pipeline/clip_frames.h"

#include <algorithm>
#include <cmath>

namespace skinlod {
namespace {

constexpr int kMostFrames = 2000;  // of all clips together

}  // namespace

std::vector<double> key_times(const Clip& clip) {
  std::vector<double> times;
  for (const Channel& channel : clip.channels) {
    if (channel.path != Path::MorphWeights)
      times.insert(times.end(), channel.times.begin(), channel.times.end());
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end(), [](double a, double b) { return b - a < 1e-5; }),
              times.end());
  return times;
}

std::vector<ClipFrame> clip_frames(std::span<const Clip> clips, double frames_per_second) {
  struct Run {
    const Clip* clip;
    double begin, end;
    double frames;  // a whole number; a forged clip may last for years
  };
  std::vector<Run> runs;
  double total = 0;
  for (const Clip& clip : clips) {
    const std::vector<double> times = key_times(clip);
    if (times.empty()) continue;
    const double frames = std::floor((times.back() - times.front()) * frames_per_second + 1 - 1e-6) + 1;
    runs.push_back({&clip, times.front(), times.back(), frames});
    total += frames;
  }
  std::vector<ClipFrame> frames;
  const int count = int(std::min<double>(total, kMostFrames));
  double first = 0;  // the number of the run's first frame among all
  auto run = runs.begin();
  for (int i = 0; i < count; ++i) {
    const double frame = std::floor(i * (total / count));
    while (frame - first >= run->frames) first += run->frames, ++run;
    frames.push_back({run->clip, std::min(run->begin + (frame - first) / frames_per_second, run->end)});
  }
  return frames;
}

}  // namespace skinlod
