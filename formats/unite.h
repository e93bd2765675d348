// SPDX-License-Identifier: MIT
#pragma once

#include "formats/import.h"

namespace skinlod {

/// Adds what the file `name` holds to `whole`, as another part of the same character: its nodes, joints,
/// geometry, materials, morphs and clips. What coincides then, in place and influences, is joined by `weld`
/// and cannot come apart.
///
/// Nodes are the same where name, parent and rest transform (within rounding) are; a node that carries a mesh
/// alone is always a new one. The two may bind in different spaces: the new geometry goes where its joints
/// already stand. Of materials that are the same in full the first one's are used. Of a clip whose name is
/// taken only the channels of what that one does not move are kept, as a clip "name (file)".
///
/// Throws Error{Input} where a joint hangs or rests elsewhere than in the files before, or where the two have
/// no joint in common.
void unite(Imported& whole, Imported other, const std::string& name);

}  // namespace skinlod
