// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/pairing.h"

namespace skinlod {

/// A place on a seam of an original, and one on the same seam of its level of detail: one of them given, the
/// other the closest to it on the seam.
struct SeamPair {
  Place original, level;  // on faces that have the seam's edge
  Edge edge;              // of the original
  double area;  // length that the given place stands for x length of the level's edge, as a share of
                // the level's area, and as it counts there
};

/// Pairs given from both sides, at rest. The same seam has the same charts on both its sides; what chart of
/// the original one of the level is made of is told by `pairs`. Each pair is there for both of the original's
/// faces at the edge: their planes differ.
std::vector<SeamPair> paired_seams(const Original& original, const Surface& level,
                                   std::span<const Pair> pairs);

}  // namespace skinlod
