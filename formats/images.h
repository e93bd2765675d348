// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "formats/import.h"

namespace skinlod {

/// The base colour image of each material, encoded as the file at `path` has it or as it lies beside that
/// file; empty where there is none.
std::vector<std::vector<unsigned char>> base_colour_images(const Imported& imported, const std::string& path);

}  // namespace skinlod
