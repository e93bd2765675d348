// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "formats/import.h"

namespace skinlod {

/// The document with the materials of another file behind its own, those of a glTF file in full: textures,
/// samplers, images, extensions. What is there already is used again. Also returns, per material of `other`,
/// where it is now. What else only glTF can say of `other` is not taken along; it is counted as
/// `ExtensionDropped`.
std::pair<std::shared_ptr<const GltfDocument>, std::vector<int>> with_materials(const GltfDocument& first,
                                                                                const Imported& other,
                                                                                Warnings& warnings);

}  // namespace skinlod
