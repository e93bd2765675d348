// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <span>
#include <vector>

#include "pipeline/pairing.h"

/// How wedges and faces hang together in their attributes.
namespace skinlod {

/// The wedges of one vertex that agree in the attribute columns [from, to), and in their part where that is
/// asked for, as one: per wedge, the number of its group.
std::vector<int> grouped(const Surface& surface, int from, int to, bool by_part);

/// Faces that hang together in texture space, as one number for each: a chart. Without uvs, faces of one part
/// that hang together at all.
std::vector<int> charts(const Surface& surface);

/// Which chart of the original each of the level's is made of: the one where most of its area finds its
/// pairs. Both are given by face. A chart without pairs has none.
std::map<int, int> chart_origins(const std::vector<int>& original, const std::vector<int>& level,
                                 std::span<const Pair> pairs);

/// Pairs whose place on the original is in the chart that the level's chart is made of. Others lie across a
/// seam, or on another layer of clothes.
std::vector<Pair> paired_in_charts(const Surface& original, const Surface& level);

}  // namespace skinlod
