// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/character.h"
#include "pipeline/warning.h"

namespace skinlod {

/// Makes `character` satisfy what the rest of the pipeline takes for granted, and says what it changed:
/// finite positions and attributes; influences sorted by joint, > 0, finite, in range, sum 1; faces of three
/// or more different corners, in range, with area, none twice; unit normals where a part has them.
/// Vertices without influence follow the nearest vertex of the same part that has some, else the part's node.
/// Throws Error{Input} where nothing is left to cook.
Warnings repair(Character& character);

/// Joins vertices that share position, influences and morph offsets to the last bit, and wedges that share
/// vertex, part and attributes. Vertices that share a position but differ otherwise stay apart; those are
/// counted in the warning. Order: a vertex stands where its first member stood.
Warnings weld(Character& character);

}  // namespace skinlod
