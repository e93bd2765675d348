// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/pairing.h"

namespace skinlod {

/// Gives `level` the normals, tangents and uvs that look most like the original's at rest, after its vertices
/// have moved from where `before` has them: least squares over `pairs` of closest places, with both
/// sides interpolated. Pairs across a seam or a hard edge are left out. Wedges of a vertex that share uvs, a
/// normal or a tangent go on sharing them; wedges that had the normals of their faces have them again; no uv
/// triangle is turned over. What `locked` vertices of the level have stays as it is.
void fit_attributes(const Surface& original, const Surface& before, std::span<const Pair> pairs,
                    const std::vector<char>& locked, Surface& level);

}  // namespace skinlod
