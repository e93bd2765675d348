// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/baseline.h"
#include "pipeline/warning.h"

namespace skinlod {

struct CookOptions {
  PoseOptions poses{};
  ChainOptions chain{};
  bool merge_materials = false;       // parts that are drawn alike become one
  std::vector<Baseline> baselines{};  // to measure beside the levels
};

/// Everything a cook finds out. `character` is the source, repaired and welded.
struct Cooked {
  Character character;
  PoseSet poses;
  Chain chain;
  std::vector<std::vector<BaselineLevel>> baselines;  // [as asked for][level]
  Warnings warnings;                                  // of repair and weld
};

/// The stage as a whole: repair, weld, choose poses, collapse, measure. Writes nothing.
Cooked cook(Character imported, const CookOptions& options, const Progress& progress = {});

}  // namespace skinlod
