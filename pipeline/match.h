// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/character.h"

namespace skinlod {

/// A surface that stands in for a character's own and moves as the character does: cooked by us or anyone.
struct Matched {
  Surface surface;  // triangles
  struct Counterpart {
    int joint;       // of the character
    Affine to_rest;  // the character's rest space from that of the surface
  };
  std::vector<Counterpart> joints;  // per joint of the surface; any for those that no vertex follows

  /// The palette that poses the surface as `palette` poses the character.
  Palette posed(const Palette& palette) const;
};

/// Matches the joints that `surface` follows, which are those of `skeleton`, with the character's by their
/// nodes' labels; of several nodes of one label the first counts. Each file may bind in a space of its own.
/// `name` is what errors call the file. Throws Error{Input} where a joint has no counterpart, or where the
/// two do not stand at the same place at rest: they would have to be the same size, way up and pose to be
/// compared.
Matched match(const Character& character, const Skeleton& skeleton, Surface surface, const std::string& name);

}  // namespace skinlod
