// SPDX-License-Identifier: MIT
#pragma once

#include "formats/import.h"
#include "formats/slod.h"

namespace skinlod {

/// A level as a file has it, and what of the level that was written each of its render vertices and faces is.
struct ReadBack {
  Surface surface;  // follows the joints of the character that was written
  std::vector<int> wedge, face;
};

/// The level before it is written.
ReadBack as_it_is(const Surface& level);

/// A level of a .slod file.
ReadBack read_back(const Surface& level, const SlodLevel& stored);

/// A GLB, written beside the character's `document` if it has one.
ReadBack read_back(const Surface& level, const Character& character, const GltfDocument* document);

}  // namespace skinlod
