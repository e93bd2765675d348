// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "pipeline/mesh.h"

namespace skinlod {

/// What a metric says about one edge. A metric may add what it needs to carry the collapse out.
struct Placement {
  double cost = 0;                       // in the metric's own unit; only the order matters to the engine
  Vec3 position;                         // of the kept vertex, rest space
  Influences influences;                 // of the kept vertex
  std::optional<MorphOffsets> morphs{};  // of the kept vertex; nothing: the metric leaves them to the mesh
};

/// One entry of the history, enough to do it again: `edge.kept` moves to `position` under `influences`, with
/// `morphs` if there are any, and stands for both ends. With `edge.removed` < 0 nothing is collapsed: the
/// vertex only takes `influences`.
struct Step {
  Edge edge;
  double cost = 0;
  Vec3 position;
  Influences influences;
  std::optional<MorphOffsets> morphs{};
};
using History = std::vector<Step>;

}  // namespace skinlod
