// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/pack.h"
#include "runtime/slod.h"

namespace skinlod {

using Bytes = std::vector<std::uint8_t>;

/// Where a direction meets the octahedron |x| + |y| + |z| = 1, its lower half folded outwards: Meyer et al.
/// 2010, "On Floating-Point Normal Vectors". A direction without length is +z.
std::array<double, 2> fold_octahedron(const Vec3& direction);

/// A stream of a level: its entry in the table, without the offset, and its bytes as stored.
struct Stream {
  slod_chunk chunk;
  Bytes bytes;
};

/// One level as it goes into a .slod file. Its place there, its checksum and the first of its sections and
/// joints are not yet known.
struct PackedLevel {
  slod_level record;
  std::vector<Stream> streams;
  std::vector<slod_section> sections;
  std::vector<slod_section_joint> section_joints;
};

/// Orders, quantises and encodes one level. `index` is its place in the chain, 0 the finest; `clip_frames`
/// the palettes that its clip box is around. Throws Error{Ours} where the level breaks what the chain
/// promises: triangles, influences within the cap.
PackedLevel pack_level(const Character& character, const Level& level, int index,
                       std::span<const Palette> clip_frames, const PackOptions& options);

}  // namespace skinlod
