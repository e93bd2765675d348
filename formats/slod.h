// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "pipeline/character.h"
#include "pipeline/evaluate.h"

namespace skinlod {

/// One level as the file has it. Render vertices whose stored position, influences and morphs are equal are
/// one vertex again, each with a wedge of its own: what was welded when it was packed is welded here.
struct SlodLevel {
  Surface surface;
  int max_influences = 0;
  double error_rms = 0;  // metres, over the example poses, as stored
  double error_max = 0;
  PosedError unseen_clip{};
  PosedError unseen_motion{};
  int sections = 0;
  std::size_t bytes = 0;  // of this level's chunks
};

/// What a .slod file holds, decoded through the runtime's loader into the pipeline's types.
struct SlodFile {
  Character character;            // skeleton, materials, parts, morph names; `surface` is empty
  std::vector<SlodLevel> levels;  // finest first
};

/// `name` is what error messages call the file. Throws Error{Input} with the loader's reason.
SlodFile read_slod(std::span<const std::byte> bytes, const std::string& name);

}  // namespace skinlod
