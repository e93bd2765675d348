// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/influences.h"

namespace skinlod {

/// One influence as GPUs read it: the weight in 255ths.
struct ByteInfluence {
  int joint;
  std::uint8_t weight;
};

/// Row per vertex.
using VertexInfluences = std::vector<std::vector<ByteInfluence>>;

/// Weights as 255ths that sum to 255, by largest remainder; heaviest first, ties by joint. Done once per
/// vertex, before any section: so all its wedges blend the same joints by the same weights in the same order,
/// and cannot come apart. Weights that are 255ths stay what they are.
std::vector<ByteInfluence> round_weights(const Influences& influences);

/// What the rounded weights come to, by ascending joint.
Influences rounded(const Influences& influences);

}  // namespace skinlod
