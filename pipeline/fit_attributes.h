// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/character.h"

namespace skinlod {

/// Gives `level` the normals, tangents and uvs that look most like the original's at rest, after its vertices
/// have moved from where `before` has them: least squares over pairs of closest places, with both sides
/// interpolated. Pairs across a seam or a hard edge are left out. Wedges of a vertex that share uvs, a
/// normal or a tangent go on sharing them; wedges that had the normals of their faces have them again; no uv
/// triangle is turned over.
void fit_attributes(const Surface& original, const Surface& before, Surface& level);

}  // namespace skinlod
