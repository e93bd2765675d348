// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "formats/gltf_builder.h"
#include "pipeline/character.h"

namespace skinlod {

/// The glTF scene of a character that comes from no glTF file: nodes at their own indices, and materials.
Json scene_of(const Character& character);

/// Adds the character's nodes from `first` on, at their own indices, to a document that has those before, and
/// its roots to the scene that is shown.
void add_nodes(const Character& character, size_t first, Json& json);

/// Adds the character's materials behind those that are there, with the textures that they name.
void add_materials(const Character& character, Json& json);

/// Writes the rest of nodes that a clip moves as translation, rotation and scale in place of a matrix: glTF
/// animates no matrix. `json` is a document with the character's nodes at their own indices.
void split_moved_matrices(const Character& character, Json& json);

/// Adds clips as animations. Channels that move the weights of morphs which no node in `has_morphs` (per
/// node) has are left out.
void add_clips(std::span<const Clip> clips, const std::vector<bool>& has_morphs, GltfBuilder& glb);

}  // namespace skinlod
