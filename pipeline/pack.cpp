// SPDX-License-Identifier: MIT
#include "pipeline/pack.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <string>

#include "pipeline/bounds.h"
#include "pipeline/clip_frames.h"
#include "pipeline/error.h"
#include "pipeline/pack_level.h"
#include "pipeline/parallel.h"
#include "runtime/slod.h"

namespace skinlod {
namespace {

// Every name once; records refer to the first byte.
struct Names {
  std::string pool{};
  std::map<std::string, std::uint32_t> place{};

  std::uint32_t at(const std::string& name) {
    const std::string text = name.c_str();  // up to the first 0
    const auto [found, fresh] = place.try_emplace(text, std::uint32_t(pool.size()));
    if (fresh) pool += text + '\0';
    return found->second;
  }
};

template <int N, class Vector>
void put(float (&to)[N], const Vector& from) {
  for (int i = 0; i < N; ++i) to[i] = float(from[i]);
}

void put(float (&to)[12], const Affine& from) {
  for (int i = 0; i < 12; ++i) to[i] = float(from(i / 4, i % 4));
}

using Matrix = std::array<float, 12>;

struct PackedSkeleton {
  std::vector<slod_node> nodes;
  std::vector<Matrix> matrices;
  std::vector<slod_joint> joints;
  std::vector<int> place;  // in `nodes`, of each node of the skeleton

  int place_of(int node) const { return node < 0 ? -1 : place[size_t(node)]; }
};

PackedSkeleton pack_skeleton(const Skeleton& skeleton, Names& names) {
  PackedSkeleton packed;
  packed.place.resize(skeleton.nodes.size());
  for (const int n : parents_first(skeleton)) {
    const Node& node = skeleton.nodes[size_t(n)];
    packed.place[size_t(n)] = int(packed.nodes.size());
    slod_node& to = packed.nodes.emplace_back();
    to = {.name = names.at(node.name),
          .parent = packed.place_of(node.parent),
          .matrix = node.matrix ? int(packed.matrices.size()) : -1,
          .translation = {},
          .rotation = {},
          .scale = {}};
    put(to.translation, node.rest.translation);
    put(to.rotation, node.rest.rotation);
    put(to.scale, node.rest.scale);
    if (node.matrix) {
      float rows[12];
      put(rows, *node.matrix);
      packed.matrices.push_back(std::to_array(rows));
    }
  }
  for (const Joint& joint : skeleton.joints) {
    slod_joint& to = packed.joints.emplace_back();
    to.node = std::uint32_t(packed.place_of(joint.node));
    put(to.inverse_bind, joint.inverse_bind);
  }
  return packed;
}

std::vector<slod_material> pack_materials(const std::vector<Material>& materials, Names& names) {
  std::vector<slod_material> packed;
  for (const Material& m : materials) {
    slod_material& to = packed.emplace_back();
    to = {.name = names.at(m.name),
          .texture = names.at(m.texture),
          .base_colour = {},
          .flags = m.double_sided ? std::uint32_t(SLOD_DOUBLE_SIDED) : 0};
    put(to.base_colour, m.base_colour);
  }
  return packed;
}

std::vector<slod_part> pack_parts(const std::vector<Part>& parts, const PackedSkeleton& skeleton,
                                  Names& names) {
  std::vector<slod_part> packed;
  for (const Part& p : parts) {
    packed.push_back({.name = names.at(p.name),
                      .node = skeleton.place_of(p.node),
                      .material = p.material,
                      .has_normal = p.has.normal,
                      .has_tangent = p.has.tangent,
                      .uv_sets = std::uint8_t(p.has.uv_sets),
                      .colour_sets = std::uint8_t(p.has.colour_sets)});
  }
  return packed;
}

std::vector<slod_morph> pack_morphs(const std::vector<Morph>& morphs, const PackedSkeleton& skeleton,
                                    Names& names) {
  std::vector<slod_morph> packed;
  for (const Morph& m : morphs) {
    packed.push_back({names.at(m.name), skeleton.place_of(m.node), float(m.weight)});
  }
  return packed;
}

void append(Bytes& bytes, const void* from, size_t size) {
  const auto* at = static_cast<const std::uint8_t*>(from);
  bytes.insert(bytes.end(), at, at + size);
}

void align(Bytes& bytes) {
  bytes.resize((bytes.size() + SLOD_ALIGNMENT - 1) / SLOD_ALIGNMENT * SLOD_ALIGNMENT);
}

template <class Item>
Stream shared_chunk(slod_kind kind, const std::vector<Item>& items) {
  Stream s{};
  s.chunk.kind = std::uint32_t(kind), s.chunk.level = SLOD_NONE;
  s.chunk.count = std::uint32_t(items.size()), s.chunk.stride = sizeof(Item);
  append(s.bytes, items.data(), items.size() * sizeof(Item));
  s.chunk.bytes = std::uint32_t(s.bytes.size());
  return s;
}

Bytes joined(std::span<const Stream> streams) {
  Bytes bytes;
  for (const Stream& s : streams) {
    append(bytes, s.bytes.data(), s.bytes.size());
    align(bytes);
  }
  return bytes;
}

// The lists over all levels, and in each level its place in them.
struct Levels {
  std::vector<slod_level> records{};
  std::vector<slod_section> sections{};
  std::vector<slod_section_joint> section_joints{};
};

Levels pack_records(std::span<const PackedLevel> packed) {
  Levels levels;
  for (const PackedLevel& l : packed) {
    slod_level& record = levels.records.emplace_back(l.record);
    const Bytes bytes = joined(l.streams);
    record.checksum = slod_checksum(bytes.data(), bytes.size());
    record.first_section = std::uint32_t(levels.sections.size());
    for (slod_section s : l.sections) {
      s.first_joint += std::uint32_t(levels.section_joints.size());
      levels.sections.push_back(s);
    }
    levels.section_joints.insert(levels.section_joints.end(), l.section_joints.begin(),
                                 l.section_joints.end());
  }
  std::uint32_t chunk = SLOD_SHARED_KINDS;
  for (size_t i = packed.size(); i-- > 0;) {
    levels.records[i].first_chunk = chunk;
    chunk += levels.records[i].chunk_count;
  }
  return levels;
}

// Header, table, and the chunks in their order. `shared` of them are for all levels.
Bytes file_bytes(std::span<const Stream> chunks, size_t shared) {
  slod_header header = {.magic = {'S', 'L', 'O', 'D', '\r', '\n', 0x1a, '\n'},
                        .version = SLOD_VERSION,
                        .endian = SLOD_ENDIAN,
                        .checksum = 0,
                        .file_bytes = 0,
                        .head_bytes = 0,
                        .chunk_count = std::uint32_t(chunks.size()),
                        .chunk_stride = sizeof(slod_chunk)};
  Bytes bytes(sizeof header);
  size_t end = sizeof header + chunks.size() * sizeof(slod_chunk);
  for (const Stream& s : chunks) {
    slod_chunk entry = s.chunk;
    end = (end + SLOD_ALIGNMENT - 1) / SLOD_ALIGNMENT * SLOD_ALIGNMENT;
    entry.offset = std::uint32_t(end);
    end += s.bytes.size();
    append(bytes, &entry, sizeof entry);
  }
  align(bytes);
  const Bytes head = joined(chunks.first(shared)), body = joined(chunks.subspan(shared));
  append(bytes, head.data(), head.size());
  header.head_bytes = std::uint32_t(bytes.size());
  append(bytes, body.data(), body.size());
  if (bytes.size() > std::numeric_limits<std::uint32_t>::max()) {
    throw Error{Fault::Input, "pack: the levels take more than 4 GB: ask for coarser ones"};
  }
  header.file_bytes = std::uint32_t(bytes.size());
  std::memcpy(bytes.data(), &header, sizeof header);
  const size_t covered = offsetof(slod_header, file_bytes);
  header.checksum = slod_checksum(bytes.data() + covered, header.head_bytes - covered);
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

}  // namespace

std::vector<std::byte> pack(const Character& character, std::span<const Level> levels,
                            const PackOptions& options) {
  std::vector<Palette> frames;
  for (const ClipFrame& frame : clip_frames(character.clips))
    frames.push_back(sample(character.skeleton, *frame.clip, frame.time));
  std::vector<PackedLevel> packed(levels.size());
  parallel_for(int(levels.size()),
               [&](int l) { packed[l] = pack_level(character, levels[l], l, frames, options); });
  const Levels records = pack_records(packed);

  Names names;
  names.at(character.name);
  const PackedSkeleton skeleton = pack_skeleton(character.skeleton, names);
  const auto materials = pack_materials(character.materials, names);
  const auto parts = pack_parts(character.parts, skeleton, names);
  const auto morphs = pack_morphs(character.morphs, skeleton, names);
  std::vector<Stream> chunks = {
      shared_chunk(SLOD_NAMES, std::vector<char>(names.pool.begin(), names.pool.end())),
      shared_chunk(SLOD_NODES, skeleton.nodes),
      shared_chunk(SLOD_MATRICES, skeleton.matrices),
      shared_chunk(SLOD_JOINTS, skeleton.joints),
      shared_chunk(SLOD_MATERIALS, materials),
      shared_chunk(SLOD_PARTS, parts),
      shared_chunk(SLOD_MORPHS, morphs),
      shared_chunk(SLOD_LEVELS, records.records),
      shared_chunk(SLOD_SECTIONS, records.sections),
      shared_chunk(SLOD_SECTION_JOINTS, records.section_joints)};
  const size_t shared = chunks.size();
  for (size_t i = packed.size(); i-- > 0;) std::ranges::move(packed[i].streams, std::back_inserter(chunks));
  const Bytes bytes = file_bytes(chunks, shared);

  slod_file file;
  if (const slod_status status = slod_open(bytes.data(), bytes.size(), &file); status != SLOD_OK) {
    throw Error{Fault::Ours, std::string("pack: the loader refuses the file: ") + slod_status_text(status)};
  }
  const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
  return {begin, begin + bytes.size()};
}

}  // namespace skinlod
