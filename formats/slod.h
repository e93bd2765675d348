// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "pipeline/character.h"

namespace skinlod {

/// What a .slod file holds, decoded through the runtime's loader into the pipeline's types.
struct SlodLevel {
  Surface surface;
  int max_influences = 0;
  double error_rms = 0;  // metres, as stored
  double error_max = 0;
  std::size_t bytes = 0;  // of this level's chunks
};
struct SlodFile {
  Character character;            // skeleton, materials, parts, morph names; `surface` is empty
  std::vector<SlodLevel> levels;  // finest first
};

/// `name` is what error messages call the file. Throws Error{Input} with the loader's reason.
SlodFile read_slod(std::span<const std::byte> bytes, const std::string& name);

}  // namespace skinlod
