// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "pipeline/chain.h"

namespace skinlod {

struct PackOptions {
  bool compress = true;  // meshoptimizer's vertex and index codecs; without them streams are stored raw
};

/// The bytes of a .slod file (runtime/slod.h owns the layout): skeleton, materials, and the levels, coarsest
/// first. Levels come in finest first, as `build_chain` gives them.
std::vector<std::byte> pack(const Character& character, std::span<const Level> levels,
                            const PackOptions& options = {});

}  // namespace skinlod
