// SPDX-License-Identifier: MIT
#include "formats/slod.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <tuple>

#include "pipeline/error.h"
#include "runtime/slod.h"

namespace skinlod {
namespace {

void require(slod_status status, const std::string& where) {
  if (status == SLOD_OK) return;
  const char* remedy = status == SLOD_NOT_SLOD        ? "give a file that `skinlod cook` wrote"
                       : status == SLOD_OTHER_VERSION ? "read it with the skinlod that wrote it"
                                                      : "copy it again, or cook it again";
  throw Error{Fault::Input, where + ": " + slod_status_text(status) + ": " + remedy};
}

Affine matrix(const float (&rows)[12]) {
  Affine m;
  for (int i = 0; i < 12; ++i) m(i / 4, i % 4) = rows[i];
  return m;
}

Vec3 vec3(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
Vec4 vec4(const float (&v)[4]) { return {v[0], v[1], v[2], v[3]}; }

PosedError as_measured(const slod_error& e) { return {.rms = e.rms, .max = e.max}; }

Skeleton read_skeleton(const slod_file& file) {
  Skeleton skeleton;
  std::vector<float> locals(12 * size_t(slod_count(&file, SLOD_NODES)));
  slod_rest_locals(&file, locals.data());
  for (std::uint32_t i = 0; i < slod_count(&file, SLOD_NODES); ++i) {
    const slod_node n = slod_get_node(&file, i);
    Node& node = skeleton.nodes.emplace_back();
    node.name = slod_name(&file, n.name);
    node.parent = n.parent;
    node.rest = {vec3(n.translation), vec4(n.rotation), vec3(n.scale)};
    if (n.matrix < 0) continue;
    node.matrix.emplace();
    for (int e = 0; e < 12; ++e) (*node.matrix)(e / 4, e % 4) = locals[12 * size_t(i) + size_t(e)];
  }
  for (std::uint32_t i = 0; i < slod_count(&file, SLOD_JOINTS); ++i) {
    const slod_joint j = slod_get_joint(&file, i);
    skeleton.joints.push_back({int(j.node), matrix(j.inverse_bind)});
  }
  return skeleton;
}

Character read_character(const slod_file& file) {
  Character c;
  c.name = slod_name(&file, 0);
  c.skeleton = read_skeleton(file);
  for (std::uint32_t i = 0; i < slod_count(&file, SLOD_MATERIALS); ++i) {
    const slod_material m = slod_get_material(&file, i);
    c.materials.push_back({.name = slod_name(&file, m.name),
                           .base_colour = vec4(m.base_colour),
                           .texture = slod_name(&file, m.texture),
                           .double_sided = (m.flags & SLOD_DOUBLE_SIDED) != 0});
  }
  for (std::uint32_t i = 0; i < slod_count(&file, SLOD_PARTS); ++i) {
    const slod_part p = slod_get_part(&file, i);
    const AttributeLayout has{.normal = p.has_normal != 0,
                              .tangent = p.has_tangent != 0,
                              .uv_sets = p.uv_sets,
                              .colour_sets = p.colour_sets};
    c.parts.push_back({slod_name(&file, p.name), p.node, p.material, has});
  }
  for (std::uint32_t i = 0; i < slod_count(&file, SLOD_MORPHS); ++i) {
    const slod_morph m = slod_get_morph(&file, i);
    c.morphs.push_back({slod_name(&file, m.name), m.node, m.weight});
  }
  return c;
}

// The streams of one level, decoded and validated by the runtime.
class LevelStreams {
 public:
  LevelStreams(const slod_file& file, std::uint32_t index, const std::string& where)
      : level(slod_get_level(&file, index)), file_(file), index_(index) {
    constexpr slod_codecs kCodecs{meshopt_decodeVertexBuffer, meshopt_decodeIndexBuffer};
    for (std::uint32_t c = level.first_chunk; c < level.first_chunk + level.chunk_count; ++c) {
      const slod_chunk chunk = slod_get_chunk(&file, c);
      if (chunk.kind < SLOD_POSITION || chunk.kind > SLOD_MORPH_OFFSET) continue;
      auto& bytes = decoded_[c];
      bytes.resize(size_t(chunk.count) * chunk.stride);
      require(slod_decode(&file, c, &kCodecs, bytes.data(), bytes.size()), where);
    }
  }

  bool has(slod_kind kind, int set = 0) const { return find(kind, set) != SLOD_NONE; }
  slod_chunk chunk(slod_kind kind, int set = 0) const { return slod_get_chunk(&file_, find(kind, set)); }

  template <class Item>
  Item item(slod_kind kind, size_t i) const {
    Item value;
    std::memcpy(&value, decoded_.at(find(kind, 0)).data() + i * sizeof(Item), sizeof(Item));
    return value;
  }

  // Row per item.
  Rows unpacked(slod_kind kind, int set = 0) const {
    const slod_chunk c = chunk(kind, set);
    const std::uint32_t components = slod_components(&c);
    std::vector<float> values(size_t(c.count) * components);
    slod_unpack(&c, decoded_.at(find(kind, set)).data(), values.data());
    using Table = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const Table>(values.data(), c.count, components).cast<double>();
  }

  const slod_level level;

 private:
  std::uint32_t find(slod_kind kind, int set) const {
    return slod_find(&file_, index_, kind, std::uint32_t(set));
  }

  const slod_file& file_;
  std::uint32_t index_;
  std::map<std::uint32_t, std::vector<std::uint8_t>> decoded_;  // by chunk
};

// What makes two render vertices one vertex, as stored: position, joints and weights, morph offsets.
struct StoredVertex {
  std::array<std::uint16_t, 4> position;
  std::map<std::uint32_t, int> influences{};        // joint, 255ths
  std::vector<std::array<int, 4>> morphs{};         // morph, offset
  std::vector<std::array<int, 4>> normal_morphs{};  // of the wedge: no part of the key
  auto key() const { return std::tie(position, influences, morphs); }
};

std::vector<StoredVertex> stored_vertices(const slod_file& file, const LevelStreams& streams) {
  const slod_level& level = streams.level;
  std::vector<StoredVertex> stored(level.vertex_count);
  for (std::uint32_t i = 0; i < level.section_count; ++i) {
    const slod_section s = slod_get_section(&file, level.first_section + i);
    for (size_t v = s.first_vertex; v < size_t(s.first_vertex) + s.vertex_count; ++v) {
      stored[v].position = streams.item<std::array<std::uint16_t, 4>>(SLOD_POSITION, v);
      for (size_t k = v * level.influence_slots; k < (v + 1) * level.influence_slots; ++k) {
        const int weight = streams.item<std::uint8_t>(SLOD_WEIGHT, k);
        const std::uint32_t local = streams.item<std::uint8_t>(SLOD_JOINT_INDEX, k);
        if (weight > 0) {
          stored[v].influences[slod_get_section_joint(&file, s.first_joint + local).joint] += weight;
        }
      }
    }
  }
  if (!streams.has(SLOD_MORPH_OFFSET)) return stored;
  for (std::uint32_t m = 0; m < slod_count(&file, SLOD_MORPHS); ++m) {
    const auto end = streams.item<std::uint32_t>(SLOD_MORPH_RANGE, m + 1);
    for (auto i = streams.item<std::uint32_t>(SLOD_MORPH_RANGE, m); i < end; ++i) {
      const auto o = streams.item<slod_morph_offset>(SLOD_MORPH_OFFSET, i);
      const auto with = [&](const std::int16_t(&d)[3]) {
        return std::array{int(m), int(d[0]), int(d[1]), int(d[2])};
      };
      if (o.position[0] || o.position[1] || o.position[2]) {
        stored[o.vertex].morphs.push_back(with(o.position));
      }
      if (o.normal[0] || o.normal[1] || o.normal[2]) stored[o.vertex].normal_morphs.push_back(with(o.normal));
    }
  }
  return stored;
}

MorphOffsets morph_offsets(const std::vector<std::array<int, 4>>& stored, const Vec3& step) {
  MorphOffsets offsets;
  for (const auto& [morph, x, y, z] : stored) offsets.push_back({morph, step.cwiseProduct(Vec3(x, y, z))});
  return offsets;
}

void read_vertices(const slod_file& file, const LevelStreams& streams, Surface& surface) {
  const std::vector<StoredVertex> stored = stored_vertices(file, streams);
  const Rows positions = streams.unpacked(SLOD_POSITION);
  const slod_chunk morphs = streams.chunk(SLOD_MORPH_OFFSET);
  const Vec3 step(morphs.step[0], morphs.step[1], morphs.step[2]);

  const auto by_key = [](const StoredVertex* a, const StoredVertex* b) { return a->key() < b->key(); };
  std::map<const StoredVertex*, int, decltype(by_key)> vertex_of(by_key);
  for (std::uint32_t i = 0; i < streams.level.section_count; ++i) {
    const slod_section s = slod_get_section(&file, streams.level.first_section + i);
    for (size_t v = s.first_vertex; v < size_t(s.first_vertex) + s.vertex_count; ++v) {
      const auto [vertex, fresh] = vertex_of.try_emplace(&stored[v], int(surface.position.size()));
      surface.wedges.push_back({vertex->second, int(s.part)});
      if (streams.has(SLOD_MORPH_OFFSET)) {
        surface.normal_morphs.push_back(
            morph_offsets(stored[v].normal_morphs, Vec3::Constant(morphs.step[3])));
      }
      if (!fresh) continue;
      surface.position.push_back(positions.row(Eigen::Index(v)).transpose());
      Influences& influences = surface.influences.emplace_back();
      for (const auto& [joint, weight] : stored[v].influences) {
        influences.push_back({int(joint), weight / 255.0});
      }
      if (streams.has(SLOD_MORPH_OFFSET)) surface.morphs.push_back(morph_offsets(stored[v].morphs, step));
    }
  }
}

void read_attributes(const LevelStreams& streams, Surface& surface) {
  AttributeLayout& layout = surface.layout;
  layout = {.normal = streams.has(SLOD_NORMAL), .tangent = streams.has(SLOD_TANGENT)};
  while (streams.has(SLOD_UV, layout.uv_sets)) ++layout.uv_sets;
  while (streams.has(SLOD_COLOUR, layout.colour_sets)) ++layout.colour_sets;

  surface.attributes.resize(streams.level.vertex_count, layout.columns());
  if (layout.normal) surface.attributes.middleCols(layout.normal_at(), 3) = streams.unpacked(SLOD_NORMAL);
  if (layout.tangent) surface.attributes.middleCols(layout.tangent_at(), 4) = streams.unpacked(SLOD_TANGENT);
  for (int i = 0; i < layout.uv_sets; ++i) {
    surface.attributes.middleCols(layout.uv_at(i), 2) = streams.unpacked(SLOD_UV, i);
  }
  for (int i = 0; i < layout.colour_sets; ++i) {
    surface.attributes.middleCols(layout.colour_at(i), 4) = streams.unpacked(SLOD_COLOUR, i);
  }
}

void read_faces(const LevelStreams& streams, Surface& surface) {
  const bool narrow = streams.chunk(SLOD_INDEX).stride == 2;
  for (size_t f = 0; f < streams.level.triangle_count; ++f) {
    std::array<int, 3> corners;
    for (size_t c = 0; c < 3; ++c) {
      corners[c] = narrow ? int(streams.item<std::uint16_t>(SLOD_INDEX, 3 * f + c))
                          : int(streams.item<std::uint32_t>(SLOD_INDEX, 3 * f + c));
    }
    surface.add_face(corners);
  }
}

}  // namespace

SlodFile read_slod(std::span<const std::byte> bytes, const std::string& name) {
  slod_file file;
  require(slod_open(bytes.data(), bytes.size(), &file), name);
  SlodFile read;
  read.character = read_character(file);
  for (std::uint32_t i = 0; i < file.level_count; ++i) {
    const LevelStreams streams(file, i, name + ": level " + std::to_string(i));
    const slod_level& l = streams.level;
    SlodLevel& level = read.levels.emplace_back();
    level.max_influences = int(l.max_influences);
    level.error_rms = l.examples.rms, level.error_max = l.examples.max;
    level.unseen_clip = as_measured(l.unseen_clip), level.unseen_motion = as_measured(l.unseen_motion);
    level.sections = int(l.section_count);
    level.bytes = slod_prefix_bytes(&file, i) - slod_get_chunk(&file, l.first_chunk).offset;
    read_vertices(file, streams, level.surface);
    read_attributes(streams, level.surface);
    read_faces(streams, level.surface);
  }
  return read;
}

}  // namespace skinlod
