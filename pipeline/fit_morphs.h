// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "pipeline/pairing.h"

namespace skinlod {

/// Gives `level` the morph offsets that move it most as `original` moves, after its vertices have moved from
/// where `before` has them, and its normals those that turn them so: least squares over `pairs`, target by
/// target, for the vertices in and next to what the target moves. Pairs across a gap that a target opens,
/// such as that between lips, are left out. No face is turned over against `before` with a target at
/// weight 1. What `locked` vertices of the level have stays as it is.
void fit_morphs(const Surface& original, const Surface& before, std::span<const Pair> pairs,
                const std::vector<char>& locked, Surface& level);

}  // namespace skinlod
