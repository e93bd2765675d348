// SPDX-License-Identifier: MIT
#pragma once

#include "formats/import.h"

namespace skinlod {

/// Reads FBX, Collada, X, B3D, MD5, Ogre and the rest of what Assimp knows, in a process of its own: Assimp
/// aborts, hangs or exhausts memory on some malformed files, and that must be no more than an Error{Input}.
Imported import_assimp(const std::string& path);

}  // namespace skinlod
