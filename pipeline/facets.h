// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/character.h"

/// Wedges that are shaded flat: their normal is that of their faces, and is to stay so.
namespace skinlod {

/// Half the cross product of two diagonals or edges: the normal of face `f`, as long as its area, at rest.
Vec3 vector_area(const Surface& surface, int f);

/// Per wedge, whether its normal is within 1 degree of all its faces' normals; none is where the surface has
/// no normals.
std::vector<char> flat_wedges(const Surface& surface);

/// Gives the wedges that are `flat` the normal of their faces, where those have one.
void shade_flat(Surface& surface, const std::vector<char>& flat);

}  // namespace skinlod
