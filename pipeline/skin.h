// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/character.h"

namespace skinlod {

/// What it takes to pose a surface, which must outlive it, laid out to be read from end to end: for a surface
/// that is posed again and again. The first pose takes as long to prepare as five to make.
class Skin {
 public:
  explicit Skin(const Surface& surface);

  /// Every vertex where morphs and palette take it: x + sum of weight x offset over the morphs, none for no
  /// weights, and then linear blend skinning, the only one in the pipeline.
  std::vector<Vec3> posed(const Palette& palette, std::span<const double> morph_weights = {}) const;

 private:
  const Surface& surface_;
  std::vector<int> end_;               // per vertex, in influences_
  std::vector<Influence> influences_;  // vertex after vertex
};

}  // namespace skinlod
