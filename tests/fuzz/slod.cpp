// SPDX-License-Identifier: MIT
#include <meshoptimizer.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "runtime/slod.h"
#include "tests/fuzz/checksums.h"

// Hostile bytes through all of the runtime: open, decode every stream, morph, skin, bound, choose. Shared by
// libFuzzer and by the test of random corruptions.
namespace skinlod::fuzz {

// Does with the file what an engine does. The first status that is not SLOD_OK, whichever call gave it.
inline slod_status play(const std::vector<std::uint8_t>& bytes, bool prefix) {
  slod_file file;
  const auto open = prefix ? slod_open_prefix : slod_open;
  if (const slod_status status = open(bytes.data(), bytes.size(), &file); status != SLOD_OK) return status;

  std::vector<float> globals(12 * size_t(slod_count(&file, SLOD_NODES)));
  std::vector<float> palette(12 * size_t(slod_count(&file, SLOD_JOINTS)));
  slod_rest_locals(&file, globals.data());
  slod_globals(&file, globals.data(), globals.data());
  slod_palette(&file, globals.data(), palette.data());
  std::vector<std::uint8_t> needed_joints(slod_count(&file, SLOD_JOINTS)),
      needed_nodes(slod_count(&file, SLOD_NODES));

  slod_status worst = SLOD_OK;
  const slod_codecs codecs{meshopt_decodeVertexBuffer, meshopt_decodeIndexBuffer};
  for (std::uint32_t level = file.first_level; level < file.level_count; ++level) {
    slod_needed(&file, level, needed_joints.data(), needed_nodes.data());
    const auto stream = [&](slod_kind kind, slod_chunk* chunk = nullptr) {
      const std::uint32_t index = slod_find(&file, level, kind, 0);
      const slod_chunk c = slod_get_chunk(&file, index);
      // To the byte, so that a sanitizer sees every access beyond the end.
      std::vector<std::uint8_t> decoded(size_t(c.count) * c.stride);
      const slod_status status = slod_decode(&file, index, &codecs, decoded.data(), decoded.size());
      if (status != SLOD_OK && index != SLOD_NONE) worst = status, decoded.clear();
      if (chunk) *chunk = c;
      return decoded;
    };
    slod_chunk positions, normals, offsets;
    const auto packed_positions = stream(SLOD_POSITION, &positions),
               packed_normals = stream(SLOD_NORMAL, &normals);
    const auto joints = stream(SLOD_JOINT_INDEX), weights = stream(SLOD_WEIGHT), indices = stream(SLOD_INDEX);
    const auto ranges = stream(SLOD_MORPH_RANGE), deltas = stream(SLOD_MORPH_OFFSET, &offsets);
    for (const slod_kind kind : {SLOD_TANGENT, SLOD_UV, SLOD_COLOUR}) {
      slod_chunk chunk;
      const auto decoded = stream(kind, &chunk);
      std::vector<float> values(size_t(chunk.count) * slod_components(&chunk));
      if (!decoded.empty()) slod_unpack(&chunk, decoded.data(), values.data());
    }
    if (packed_positions.empty() || joints.empty() || weights.empty() || indices.empty()) continue;

    std::vector<float> x(3 * size_t(positions.count)), n(3 * size_t(normals.count));
    slod_unpack(&positions, packed_positions.data(), x.data());
    if (!packed_normals.empty()) slod_unpack(&normals, packed_normals.data(), n.data());
    if (!ranges.empty() && !deltas.empty()) {
      std::vector<std::uint32_t> range(ranges.size() / 4);
      std::vector<slod_morph_offset> offset(deltas.size() / sizeof(slod_morph_offset));
      std::memcpy(range.data(), ranges.data(), ranges.size());
      std::memcpy(offset.data(), deltas.data(), deltas.size());
      const std::vector<float> on(slod_count(&file, SLOD_MORPHS), 1.0f);
      slod_add_morphs(&file, &offsets, range.data(), offset.data(), on.data(), x.data(),
                      packed_normals.empty() ? nullptr : n.data());
    }
    slod_skin(&file, level, joints.data(), weights.data(), palette.data(), x.data(),
              packed_normals.empty() ? nullptr : n.data());
    float lowest[3], highest[3];
    slod_posed_bounds(&file, level, globals.data(), lowest, highest);
  }
  const slod_view view{5, 1.7f, 1080, 1, 0.2f, 1};
  slod_select_level(&file, &view, 1);
  for (std::uint32_t i = 0; i < slod_count(&file, SLOD_NODES); ++i) {
    if (std::strlen(slod_name(&file, slod_get_node(&file, i).name)) > bytes.size()) worst = SLOD_BAD_RECORD;
  }
  return worst;
}

}  // namespace skinlod::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> bytes(data, data + size);
  skinlod::fuzz::play(bytes, false);
  skinlod::fuzz::repair_checksums(bytes);
  skinlod::fuzz::play(bytes, false);
  skinlod::fuzz::play(bytes, true);
  return 0;
}
