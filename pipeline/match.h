// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/pose.h"

namespace skinlod {

/// A surface that stands in for a character's own and moves as the character does: cooked by us or anyone.
struct Matched {
  Surface surface;  // triangles
  struct Counterpart {
    int joint;       // of the character
    Affine to_rest;  // the character's rest space from that of the surface
  };
  std::vector<Counterpart> joints;  // per joint of the surface; any for those that no vertex follows
  std::vector<int> morphs;          // per morph of the surface, the character's; or -1

  /// The pose that the surface has where the character has `pose`.
  Pose posed(const Pose& pose) const;
};

/// Matches the joints that `surface` follows, which are those of `candidate`, with the character's by the
/// labels of their nodes and of the nodes above, or of their nodes alone, and the morphs by their own and
/// their nodes' names, or by their own alone; of several of one name the first counts. Each file may bind in
/// a space of its own, or have nodes with axes and units of their own; which it is the surfaces tell, lying
/// closer to each other. A morph without a counterpart stays off. `name` is what errors call the file. Throws
/// Error{Input} where a joint has no counterpart, or where the two do not stand at the same place at rest:
/// they would have to be the same size, way up and pose to be compared.
Matched match(const Character& character, const Character& candidate, Surface surface,
              const std::string& name);

}  // namespace skinlod
