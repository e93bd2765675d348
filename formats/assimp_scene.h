// SPDX-License-Identifier: MIT
#pragma once

#include <assimp/scene.h>

#include <string>

#include "formats/import.h"

namespace skinlod {

/// The character in an Assimp scene, read without any post-processing and with FBX pivots folded into their
/// nodes. Every vertex Assimp gives becomes a vertex with one wedge. `path` names the file in errors; its
/// ending tells what the format leaves unsaid (the unit, the ticks of a second).
Imported read_scene(const aiScene& scene, const std::string& path, Need need);

}  // namespace skinlod
