// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "pipeline/mesh.h"
#include "pipeline/neighbourhood.h"

/// How wedges and faces hang together in their attributes.
namespace skinlod {

/// The wedges of one vertex that agree in the attribute columns [from, to), and in their part where that is
/// asked for, as one: per wedge, the number of its group.
std::vector<int> grouped(const Surface& surface, int from, int to, bool by_part);

/// The sheets: wedges of one vertex and part that have one uv in every set.
std::vector<int> sheets(const Surface& surface);

/// Faces that hang together in texture space, as one number for each: a chart. Without uvs, faces of one part
/// that hang together at all.
std::vector<int> charts(const Surface& surface);

/// An edge whose two faces, on two sides of it, do not hang together in texture space along it.
struct SeamLine {
  Edge edge;  // `kept` is the lower end
  std::array<int, 2> faces;
};

/// All of a surface of triangles, by ascending ends. `faces` is its neighbourhood.
std::vector<SeamLine> seam_lines(const Surface& surface, const Neighbourhood& faces);

}  // namespace skinlod
