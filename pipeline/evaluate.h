// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/pose.h"

namespace skinlod {

/// Samples per surface and pose where nothing else is asked for.
inline constexpr int kSamples = 4000;

/// Distances between two posed surfaces, in metres: over both directions and all poses.
struct PosedError {
  double rms = 0;
  double max = 0;
};

/// The two-sided distance between `original` and each of `levels` in each pose: [level][pose]. All are
/// sampled by area at rest, with the same barycentric samples in every pose; each posed sample is compared
/// with the closest point of the other surface in that pose. `samples` is the number per surface and pose.
/// Shares nothing with the metrics but skinning. The same for any thread count and CPU.
std::vector<std::vector<PosedError>> posed_errors(const Surface& original,
                                                  std::span<const Surface* const> levels,
                                                  std::span<const Pose> poses, int samples = kSamples);

/// RMS of the rms, maximum of the max; {0, 0} for no poses.
PosedError total(std::span<const PosedError> errors);

}  // namespace skinlod
