// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "pipeline/influences.h"
#include "pipeline/mesh.h"
#include "pipeline/pairing.h"
#include "pipeline/pose.h"

namespace skinlod {

struct RefineOptions {
  int rounds = 1;          // 0: nothing is done
  int max_influences = 4;  // per vertex; 0: no limit
  WeightRule weights = WeightRule::NonNegative;
  Borders borders = Borders::Free;
  bool attributes = true;    // fit them too, and hold seams
  bool byte_weights = true;  // weights end as 255ths and positions at their best with those, but where that
                             // would turn a face
};

/// Fits a finished level of triangles to its original, as it moves through `poses`: what greedy collapse
/// decides one vertex at a time is solved for again, for all positions and influences together. Faces stay,
/// seams stay by those of the original, and a locked border stays in all that it has. The RMS
/// distance falls. The largest, which lies in few places, may rise: nothing here looks at it.
Surface refined(const Original& original, Surface level, std::span<const Pose> poses,
                const RefineOptions& options = {});

}  // namespace skinlod
