// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/metrics/skinned_quadric.h"

namespace skinlod {

/// Where a vertex is at rest, and the joints that it follows: what a SkinnedQuadric is a function of.
struct SkinnedPoint {
  Vec3 position;
  Influences influences;
};

/// E at the point, over those of its influences that are among E's joints, brought to sum 1.
double error_at(const SkinnedQuadric& E, const SkinnedPoint& point);

/// The point that minimises E, found from `start` by solving for position and weights in turn; then, with
/// more than `cap` influences (0: no limit), once more over so many of them alone. Landreneau & Schaefer 2009
/// (section 3.2) keep the largest; we leave out, one after another, the one whose loss costs least once the
/// others are solved again: two joints that move almost alike may both have large weights, of which one will
/// do. Without a cap it is never worse than `start`.
SkinnedPoint solved(const SkinnedQuadric& E, const SkinnedPoint& start, int cap, WeightRule rule);

/// The same for the weights alone, the point staying where it is.
Influences reweighted(const SkinnedQuadric& E, const SkinnedPoint& start, int cap, WeightRule rule);

/// The point with weights in 255ths, as they are stored: those that are found from `round_weights` on by
/// giving one 255th at a time from one joint to another while that lowers E, the point moving to where E is
/// least.
SkinnedPoint rounded(const SkinnedQuadric& E, const SkinnedPoint& point);

/// The influences on `joints`, and the weights that they are.
Weights weights_over(const std::vector<int>& joints, const Influences& influences);
Influences influences_of(const std::vector<int>& joints, const Weights& w);

}  // namespace skinlod
