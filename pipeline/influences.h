// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/character.h"

namespace skinlod {

/// (1 - t) a + t b over the joints of either; sum 1 where both sum to 1.
Influences blend(const Influences& a, const Influences& b, double t);

/// The `count` largest influences (ties: the lower joint), scaled to sum 1, by ascending joint.
/// All of them for `count` 0.
Influences largest(Influences influences, int count);

}  // namespace skinlod
