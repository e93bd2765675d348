// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "formats/import.h"

namespace skinlod {

/// Reads glTF 2.0, binary or JSON with data URIs or files beside it. See `import_character`;
/// for Need::ClipsOnly, the nodes and clips alone.
Imported import_gltf(const std::string& path, Need need = Need::Character);

/// A GLB that shows `surface` on the skeleton of `character`, with its clips and materials. Where `document`
/// is there, everything in it that is not geometry (extensions, extras, cameras, lights, textures) is kept;
/// the character may have more than it, nodes, parts and materials that were united with it.
std::vector<std::byte> write_glb(const Character& character, const Surface& surface,
                                 const GltfDocument* document = nullptr);

}  // namespace skinlod
