// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "formats/gltf_builder.h"
#include "formats/gltf_document.h"

namespace skinlod {

/// What a document becomes without its geometry: `json` without meshes, skins and the extensions that pack
/// them; nodes without mesh; images and all that animations and other extensions refer to moved over to the
/// builder. Channels that move the weights of morphs which no node in `has_morphs` (per node) has are left
/// out.
void keep_document(const GltfDocument& doc, const std::vector<bool>& has_morphs, GltfBuilder& glb);

}  // namespace skinlod
