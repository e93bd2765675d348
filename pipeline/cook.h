// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/chain.h"
#include "pipeline/warning.h"

namespace skinlod {

struct CookOptions {
  PoseOptions poses{};
  ChainOptions chain{};
};

/// Everything a cook finds out. `character` is the source, repaired and welded.
struct Cooked {
  Character character;
  PoseSet poses;
  Chain chain;
  Warnings warnings;  // of repair and weld
};

/// The stage as a whole: repair, weld, choose poses, collapse, measure. Writes nothing.
Cooked cook(Character imported, const CookOptions& options, const Progress& progress = {});

}  // namespace skinlod
