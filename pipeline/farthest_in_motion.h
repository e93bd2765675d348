// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/moving.h"

namespace skinlod {

/// Finds `Deviation::bound` of each level in each pose, [level][pose]: until then it is the largest distance
/// of a sample. `groups` as in DeviationOptions.
void find_bounds(const Moving& original, std::span<const Moving> levels, const std::vector<int>& groups,
                 std::vector<std::vector<Deviation>>& found);

}  // namespace skinlod
