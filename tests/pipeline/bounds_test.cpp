// SPDX-License-Identifier: MIT
#include "pipeline/bounds.h"

#include <cstring>

#include "tests/posed_box.h"

namespace skinlod {
namespace {

// A tube in which every vertex follows eight joints, the near ones most.
std::vector<std::byte> eight_influences() {
  Character c = bending_tube(8, 10, 8);
  for (size_t v = 0; v < c.surface.position.size(); ++v) {
    Influences& influences = c.surface.influences[v];
    influences.clear();
    double sum = 0;
    for (int j = 0; j < 8; ++j) {
      const double away = c.surface.position[v].y() - j - 0.5;
      influences.push_back({j, 1 / (0.1 + away * away)});
      sum += influences.back().weight;
    }
    for (Influence& i : influences) i.weight /= sum;
  }
  const std::array levels = {as_level(c.surface, 8, 0)};
  return pack(c, levels);
}

// The file as an older skinlod wrote it: no chunk is of the kinds that are newer.
std::vector<std::byte> without_boxes(std::vector<std::byte> bytes) {
  slod_header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  for (std::uint32_t i = 0; i < header.chunk_count; ++i) {
    std::byte* at = bytes.data() + sizeof header + i * sizeof(slod_chunk);
    slod_chunk chunk;
    std::memcpy(&chunk, at, sizeof chunk);
    if (chunk.kind == SLOD_GROUP || chunk.kind == SLOD_CLIP_BOX) chunk.kind = 1000 + chunk.kind;
    std::memcpy(at, &chunk, sizeof chunk);
  }
  const size_t covered = offsetof(slod_header, file_bytes);
  header.checksum = slod_checksum(bytes.data() + covered, header.head_bytes - covered);
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

}  // namespace

TEST_SUITE("bounds") {
  TEST_CASE("in any pose and with any morphs every vertex is inside the posed bounds") {
    constexpr int kPoses = 10000;
    for (const auto& bytes : {packed_tube(), eight_influences(), without_boxes(packed_tube())}) {
      const slod_file file = opened(bytes);
      for (std::uint32_t level = 0; level < file.level_count; ++level) {
        CAPTURE(level);
        const Held held = hold(file, level, kPoses);
        CHECK(held.outside == 0);
        CHECK(held.outside_shrunk > 0);
      }
    }
  }

  TEST_CASE("in the clips the posed bounds are close, and the clip box is around all frames and no larger") {
    Character character = bending_tube(12, 10, 5);
    const std::array levels = {as_level(character.surface, 4, 0),
                               as_level(bending_tube(6, 4, 5).surface, 4, 0.01)};
    const auto bytes = pack(character, levels);
    const slod_file file = opened(bytes);
    for (std::uint32_t level = 0; level < file.level_count; ++level) {
      CAPTURE(level);
      const Looseness loose = looseness(file, level, character);
      CHECK(loose.frames > 60);
      CHECK(loose.outside == 0);
      CHECK(loose.outside_shrunk > 0);
      CHECK(loose.mean < 1.5);
      CHECK(loose.outside_clip_box == 0);
      CHECK(loose.outside_shrunk_clip_box > 0);
    }
    character.clips.clear();
    const auto without = pack(character, levels);
    const slod_file still = opened(without);
    float low[3], high[3];
    CHECK(slod_clip_bounds(&still, 0, low, high) == 0);
  }

  TEST_CASE("a prefix is bounded by the joints' boxes until the level is there") {
    const auto bytes = packed_tube();
    const slod_file whole = opened(bytes);
    slod_header header;
    std::memcpy(&header, bytes.data(), sizeof header);
    slod_file head;
    REQUIRE(slod_open_prefix(bytes.data(), header.head_bytes, &head) == SLOD_OK);
    std::mt19937 random(3);
    const auto nodes = random_globals(whole, random);
    PosableLevel level(whole, 0);
    float low[3], high[3];
    slod_posed_bounds(&head, 0, nodes.data(), low, high);
    const Box early{Vec3(low[0], low[1], low[2]), Vec3(high[0], high[1], high[2])};
    CHECK(early.contains(level.box(nodes)));
    CHECK(volume(early) > volume(level.bounds(nodes)));
    CHECK(slod_clip_bounds(&head, 0, low, high) == 0);
  }
}

}  // namespace skinlod
