// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/character.h"
#include "pipeline/warning.h"

namespace skinlod {

/// Makes `character` satisfy what the rest of the pipeline takes for granted, and says what it changed:
/// positions finite (below 1e12 metres) and attributes finite; normals and tangents of unit length;
/// influences sorted by joint, > 0, in range, sum 1; faces of three or more corners, in range, with area;
/// clips with finite values, ascending times and one channel for each thing that they move. Vertices without
/// influence follow the nearest vertex of the same part that has some, else the part's node. Vertices in no
/// face are mended without a word.
/// Throws Error{Input} where the skeleton is broken or nothing is left to cook.
Warnings repair(Character& character);

/// Lets parts that are drawn alike, with one material at one node and the same attributes, be drawn together:
/// as the first of them. The others stay in the list, without faces.
void merge_materials(Character& character);

/// Joins, in a repaired character, vertices that share position, influences and morph offsets, and wedges
/// that share vertex, part and attributes to the last bit. Order: a vertex stands where its first member
/// stood; faces keep theirs. Vertices and wedges that no face uses are dropped; so are faces that are there
/// twice (same part, same vertices in the same turn) and doubled corners.
///
/// Positions are the same when they agree to 24 bits of their largest coordinate, which is what files hold,
/// and morph offsets to 1e-7 of the diagonal: two meshes that meet come here through matrices of their own,
/// and must not be torn apart by the last bits of a double.
/// Influences are the same when no weight differs by more than 1e-4: exporters normalise the copies of a
/// vertex on both sides of a uv seam separately, and the seam would open. The first one's are kept, and the
/// joined vertices counted as `WeightsNearlyEqual`.
///
/// Vertices that share a position but differ otherwise stay apart; those are counted as `PartsCoincide`.
Warnings weld(Character& character);

/// The keys of a channel in the order of their times, without those that another follows at the same time,
/// which glTF forbids. Times are compared as floats: two that differ in double only become one when they are
/// written.
std::vector<size_t> keys_in_order(std::span<const double> times);

/// The points, influences and faces of a surface and nothing else: one part, one wedge per vertex, no
/// attribute columns, no morphs; then welded, since all that told some vertices apart may be gone. So no seam
/// is left to hold a collapse back. Throws Error{Input} where no face is left.
Surface without_attributes(const Surface& surface);

}  // namespace skinlod
