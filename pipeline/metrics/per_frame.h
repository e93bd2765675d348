// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/character.h"

namespace skinlod {

/// The reference line: Garland & Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH
/// 1997, on one posed frame alone, as Landreneau & Schaefer 2009 (section 5) have it when they come "much
/// closer to the quality of static mesh simplification methods".
///
///   cost(x) = x'(Q_u + Q_v)x     (Q: of the frame's own surface)
///
/// What a simplifier can do that need not move: every frame may take other triangles and other points, so no
/// level of detail can be made of it. Other methods' errors are given as multiples of this one's.
///
/// `posed` is where each vertex of `source` stands in the frame; the weights only say which vertices that
/// stand at one place are one. Seams are free: positions alone matter. For each of `triangles`, which must
/// descend, the surface once it has at most so many, or as few as can be had; its points are posed points,
/// following joint 0 alone. One run, read off at each count. Throws Error{Usage} for counts that ascend.
///
/// Departures are those of RestPoseMetric.
std::vector<Surface> simplify_frame(const Surface& source, std::span<const Vec3> posed,
                                    std::span<const int> triangles);

}  // namespace skinlod
