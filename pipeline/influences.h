// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/character.h"

namespace skinlod {

/// Which weights a solve may find.
enum class WeightRule {
  NonNegative,  // >= 0, as GPUs and file formats want them
  Signed,       // any of sum 1, as Landreneau & Schaefer print it: for comparison, no engine takes them
};

/// (1 - t) a + t b over the joints of either, without those whose weights cancel; sum 1 where both sum to 1.
Influences blend(const Influences& a, const Influences& b, double t);

/// How `count` weights are brought to sum 1: by one factor. Where signed weights all but cancel a factor
/// would throw them far off, and they are shifted alike instead, by as little as gives them their sum.
struct ToSumOne {
  ToSumOne(double sum, double magnitude,
           int count);  // `magnitude`: the sum of the weights without their signs
  double operator()(double weight) const { return weight / divisor + shift; }
  double divisor = 1, shift = 0;
};

/// The `count` largest influences by magnitude (ties: the lower joint), brought to sum 1, by ascending joint.
/// All of them, as they are, for `count` 0.
Influences largest(Influences influences, int count);

}  // namespace skinlod
