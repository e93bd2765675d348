// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/metrics/surface_quadrics.h"
#include "pipeline/pairing.h"

namespace skinlod {

/// A place on a seam or an open border of an original, and one on the same line of its level of detail: one
/// of them given, the other the closest to it on the line.
struct LinePair {
  Place original, level;  // on faces that have the line's edge
  Edge edge;              // of the original
  double area;            // weight x length x length of the level's edge, as a share of the level's area
};

/// Pairs given from both sides, at rest. The same line has the same charts on both its sides, or one and
/// none; what chart of the original one of the level is made of is told by `pairs`. What two faces of the
/// original share is given once for each: their planes differ.
std::vector<LinePair> paired_lines(const Surface& original, const Surface& level, std::span<const Pair> pairs,
                                   LineWeights weights = {});

}  // namespace skinlod
