// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/character.h"

namespace skinlod {

/// A moment of a clip.
struct ClipFrame {
  const Clip* clip;
  double time;  // seconds
};

/// The times of all keys that move a node, ascending; times that rounding has split are one.
std::vector<double> key_times(const Clip& clip);

/// The clips' frames from each clip's first key to its last; of more than 2,000 of all clips together some,
/// evenly. None of a clip that moves no node.
std::vector<ClipFrame> clip_frames(std::span<const Clip> clips, double frames_per_second = 30);

}  // namespace skinlod
