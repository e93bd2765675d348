// SPDX-License-Identifier: MIT
#pragma once

#include "formats/import.h"

namespace skinlod {

/// Reads FBX, Collada, X, B3D, MD5, Ogre and the rest of what Assimp knows, in a process of its own: Assimp
/// aborts, hangs or exhausts memory on some malformed files, and that must be no more than an Error{Input}.
/// FBX comes out in metres and Y up, Collada too; the other formats have no unit and are taken as they are.
Imported import_assimp(const std::string& path, Need need = Need::Character);

/// True where Assimp has a reader for files that end in "." and `extension` (lower case).
bool assimp_reads(const std::string& extension);

}  // namespace skinlod
