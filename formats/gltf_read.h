// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "formats/gltf_document.h"
#include "pipeline/character.h"
#include "pipeline/warning.h"

/// The steps of a glTF import, each over a document whose indices are not yet known to be right.
namespace skinlod {

/// "mesh 3": how messages and warnings call what has no name.
std::string numbered(const char* what, size_t index);

/// Every glTF node at its own index, without joints. A rotation of zeros is taken for none, with a warning,
/// and taken out of the document's JSON as well. Throws Error{Input} where nodes form no forest.
Skeleton read_nodes(GltfDocument& doc, Warnings& warnings);

/// Takes out of the document's JSON what a scene lists a second time, with a warning.
void drop_repeated_roots(GltfDocument& doc, Warnings& warnings);

/// For each node whether it is below the default scene, else the first one; all are in a file without scenes.
std::vector<bool> nodes_in_scene(const GltfDocument& doc);

/// Node and inverse bind matrix of each of the skin's joints.
std::vector<Joint> read_skin(const GltfDocument& doc, int skin);

/// The index in "images" of what a material has as its base colour.
std::optional<size_t> base_colour_image(const GltfDocument& doc, size_t material);

std::vector<Material> read_materials(const GltfDocument& doc);

/// Adds joints, parts, morphs and surface to a character that has its nodes. Records in the document which
/// primitive each part is. Throws Error{Input} where no skin or no face is there.
void read_surface(GltfDocument& doc, Character& character, Warnings& warnings);

/// One clip per animation. Channels that cannot be used are left out, with a warning; those with values that
/// are not finite, or that move what another moves, are taken out of the document's JSON as well, for no
/// reader could use them. Keys may be out of order: `repair` sorts them.
std::vector<Clip> read_clips(GltfDocument& doc, Warnings& warnings);

/// The number of morph targets of the mesh at `node`, 0 where there is none.
int target_count(const GltfDocument& doc, int node);

}  // namespace skinlod
