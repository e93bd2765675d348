// SPDX-License-Identifier: MIT
#pragma once

#include <set>
#include <vector>

#include "pipeline/byte_weights.h"

namespace skinlod {

/// What is drawn with one call.
struct Section {
  int part;
  int max_influences = 0;           // of any of its vertices
  std::set<int> joints{};           // at most SLOD_MAX_SECTION_JOINTS
  std::vector<int> wedges{};        // one per render vertex
  std::vector<unsigned> indices{};  // into `wedges`
};

/// The draw calls of a surface of triangles: by part, and within a part by ascending influences, so that an
/// engine can draw many triangles with a shader for one or two. A section more is made where that pays, see
/// `kBlendsPerDraw`. Indices stand in the order that reuses vertices best, vertices in the order in which
/// they are fetched. Overdraw is left alone: an order that is good at rest says little about other poses.
std::vector<Section> split(const Surface& surface, const VertexInfluences& influences);

/// A section more must save as many blended matrices, counted by shaders for 1, 2, 4 and 8 influences and
/// with the vertices that then stand in two sections.
inline constexpr int kBlendsPerDraw = 2000;

}  // namespace skinlod
