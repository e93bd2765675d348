// SPDX-License-Identifier: MIT
#include "pipeline/pack_level.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <string>

#include "pipeline/bounds.h"
#include "pipeline/error.h"
#include "pipeline/sections.h"

namespace skinlod {
namespace {

// Equal steps from a smallest value on.
struct Grid {
  float base = 0, step = 0;

  Grid(double lowest, double highest, int steps)
      : base(float(lowest)), step(float((highest - double(base)) / steps)) {}

  int nearest(double x, int steps) const {
    if (!(step > 0)) return 0;
    return int(std::lrint(std::clamp((x - double(base)) / double(step), 0.0, double(steps))));
  }
};

// -1 to 1 as -one to one.
template <class Integer>
Integer snorm(double x, int one) {
  return Integer(std::lrint(std::clamp(x, -1.0, 1.0) * one));
}

template <class Item>
Stream stream(slod_kind kind, int set, const std::vector<Item>& items, std::span<const Grid> grids = {}) {
  Stream s{};
  s.chunk.kind = std::uint32_t(kind), s.chunk.set = std::uint32_t(set);
  s.chunk.count = std::uint32_t(items.size()), s.chunk.stride = sizeof(Item);
  for (size_t i = 0; i < grids.size(); ++i) s.chunk.base[i] = grids[i].base, s.chunk.step[i] = grids[i].step;
  s.bytes.resize(items.size() * sizeof(Item));
  std::memcpy(s.bytes.data(), items.data(), s.bytes.size());
  return s;
}

// Of `components` numbers a render vertex, as 16 bits each on a grid of their own; Item has room for them.
// `value(wedge, c)` gives them.
template <class Item, class Value>
Stream unorm_stream(slod_kind kind, int set, int components, std::span<const int> wedges, Value value) {
  constexpr int kSteps = 65535;
  std::vector<Item> items(wedges.size(), Item{});
  std::vector<Grid> grids;
  for (int c = 0; c < components; ++c) {
    const auto component = [&](int w) { return value(w, c); };
    const Grid& grid = grids.emplace_back(component(std::ranges::min(wedges, {}, component)),
                                          component(std::ranges::max(wedges, {}, component)), kSteps);
    for (size_t i = 0; i < wedges.size(); ++i) {
      items[i][size_t(c)] = std::uint16_t(grid.nearest(value(wedges[i], c), kSteps));
    }
  }
  return stream(kind, set, items, grids);
}

template <class Item, class Value>
Stream vertex_stream(slod_kind kind, int set, std::span<const int> wedges, std::span<const Grid> grids,
                     Value value) {
  std::vector<Item> items;
  for (const int w : wedges) items.push_back(value(w));
  return stream(kind, set, items, grids);
}

using Short2 = std::array<std::uint16_t, 2>;
using Short4 = std::array<std::uint16_t, 4>;
using Signed2 = std::array<std::int16_t, 2>;
using Signed4 = std::array<std::int8_t, 4>;
using Byte4 = std::array<std::uint8_t, 4>;

void add_attributes(std::vector<Stream>& streams, const Surface& surface, std::span<const int> wedges) {
  const AttributeLayout& layout = surface.layout;
  const Rows& table = surface.attributes;
  const auto folded = [&](int w, int at) { return fold_octahedron(table.row(w).segment<3>(at).transpose()); };
  if (layout.normal) {
    streams.push_back(vertex_stream<Signed2>(SLOD_NORMAL, 0, wedges, {}, [&](int w) {
      const auto [x, y] = folded(w, layout.normal_at());
      return Signed2{snorm<std::int16_t>(x, 32767), snorm<std::int16_t>(y, 32767)};
    }));
  }
  if (layout.tangent) {
    streams.push_back(vertex_stream<Signed4>(SLOD_TANGENT, 0, wedges, {}, [&](int w) {
      const auto [x, y] = folded(w, layout.tangent_at());
      const std::int8_t handedness = table(w, layout.tangent_at() + 3) < 0 ? -127 : 127;
      return Signed4{snorm<std::int8_t>(x, 127), snorm<std::int8_t>(y, 127), handedness, 0};
    }));
  }
  for (int set = 0; set < layout.uv_sets; ++set) {
    streams.push_back(unorm_stream<Short2>(SLOD_UV, set, 2, wedges,
                                           [&](int w, int c) { return table(w, layout.uv_at(set) + c); }));
  }
  const std::vector<Grid> unit(4, Grid(0, 1, 255));
  for (int set = 0; set < layout.colour_sets; ++set) {
    streams.push_back(vertex_stream<Byte4>(SLOD_COLOUR, set, wedges, unit, [&](int w) {
      Byte4 rgba;
      for (int c = 0; c < 4; ++c) {
        rgba[size_t(c)] = std::uint8_t(unit[0].nearest(table(w, layout.colour_at(set) + c), 255));
      }
      return rgba;
    }));
  }
}

// `Slots` is an array of 4 or 8 bytes.
template <class Slots>
void add_influences(PackedLevel& packed, const std::vector<Section>& sections, const Surface& surface,
                    const VertexInfluences& influences) {
  std::vector<Slots> joints, weights;
  for (size_t s = 0; s < sections.size(); ++s) {
    for (const int j : sections[s].joints) packed.section_joints.push_back({std::uint32_t(j), {}, {}});
    for (const int w : sections[s].wedges) {
      Slots& joint = joints.emplace_back(Slots{});
      Slots& weight = weights.emplace_back(Slots{});
      std::uint32_t slot = 0;
      for (const ByteInfluence& i : influences[size_t(surface.wedges[size_t(w)].vertex)]) {
        const auto place = std::distance(sections[s].joints.begin(), sections[s].joints.find(i.joint));
        joint[slot] = std::uint8_t(place), weight[slot] = i.weight;
        ++slot;
      }
    }
  }
  packed.streams.push_back(stream(SLOD_JOINT_INDEX, 0, joints));
  packed.streams.push_back(stream(SLOD_WEIGHT, 0, weights));
}

void add_sections(PackedLevel& packed, const std::vector<Section>& sections) {
  std::vector<std::uint32_t> indices;
  std::uint32_t vertices = 0, joints = 0;
  for (const Section& s : sections) {
    packed.sections.push_back({.part = std::uint32_t(s.part),
                               .first_index = std::uint32_t(indices.size()),
                               .index_count = std::uint32_t(s.indices.size()),
                               .first_vertex = vertices,
                               .vertex_count = std::uint32_t(s.wedges.size()),
                               .first_joint = joints,
                               .joint_count = std::uint32_t(s.joints.size()),
                               .max_influences = std::uint32_t(s.max_influences)});
    for (const unsigned i : s.indices) indices.push_back(vertices + i);
    vertices += std::uint32_t(s.wedges.size()), joints += std::uint32_t(s.joints.size());
  }
  // 65535 stays free: it restarts strips.
  if (vertices < 65536) {
    const std::vector<std::uint16_t> narrow(indices.begin(), indices.end());
    packed.streams.push_back(stream(SLOD_INDEX, 0, narrow));
  } else {
    packed.streams.push_back(stream(SLOD_INDEX, 0, indices));
  }
}

double largest_component(const std::vector<MorphOffsets>& lists) {
  double size = 0;
  for (const auto& list : lists) {
    for (const MorphOffset& m : list) size = std::max(size, m.delta.cwiseAbs().maxCoeff());
  }
  return size;
}

// Adds the streams, if any vertex moves at all, and gives what they unpack to.
Deltas add_morphs(std::vector<Stream>& streams, int morphs, const Surface& surface,
                  std::span<const int> wedges) {
  constexpr int kSteps = 32767;
  const Grid point(0, largest_component(surface.morphs), kSteps);
  const Grid normal(0, largest_component(surface.normal_morphs), kSteps);
  const auto round = [](const Vec3& delta, const Grid& grid, std::int16_t* to) {
    for (int i = 0; i < 3; ++i) {
      const int size = grid.nearest(std::abs(delta[i]), kSteps);
      to[i] = std::int16_t(delta[i] < 0 ? -size : size);
    }
  };
  std::map<std::pair<int, std::uint32_t>, slod_morph_offset> sorted;  // by morph, then render vertex
  const auto at = [&](int morph, size_t v) -> slod_morph_offset& {
    const slod_morph_offset still{std::uint32_t(v), {}, {}};
    return sorted.try_emplace({morph, std::uint32_t(v)}, still).first->second;
  };
  for (size_t v = 0; v < wedges.size(); ++v) {
    const size_t w = size_t(wedges[v]), vertex = size_t(surface.wedges[w].vertex);
    if (!surface.morphs.empty()) {
      for (const MorphOffset& m : surface.morphs[vertex]) round(m.delta, point, at(m.morph, v).position);
    }
    if (!surface.normal_morphs.empty()) {
      for (const MorphOffset& m : surface.normal_morphs[w]) round(m.delta, normal, at(m.morph, v).normal);
    }
  }
  Deltas deltas(wedges.size());
  if (sorted.empty()) return deltas;

  std::vector<slod_morph_offset> offsets;
  std::vector<std::uint32_t> ranges(size_t(morphs) + 1, 0);
  for (const auto& [key, offset] : sorted) {
    offsets.push_back(offset);
    ++ranges[size_t(key.first) + 1];
    deltas[offset.vertex].push_back(double(point.step) *
                                    Vec3(offset.position[0], offset.position[1], offset.position[2]));
  }
  for (size_t m = 0; m < size_t(morphs); ++m) ranges[m + 1] += ranges[m];
  streams.push_back(stream(SLOD_MORPH_RANGE, 0, ranges));
  streams.push_back(stream(SLOD_MORPH_OFFSET, 0, offsets, std::array{point, point, point, normal}));
  return deltas;
}

// Bounds are those of the points as they unpack, not as they came.
std::vector<Vec3> unpacked_points(const Stream& positions) {
  std::vector<float> values(3 * size_t(positions.chunk.count));
  slod_unpack(&positions.chunk, positions.bytes.data(), values.data());
  std::vector<Vec3> points;
  for (size_t i = 0; i < values.size(); i += 3) points.emplace_back(values[i], values[i + 1], values[i + 2]);
  return points;
}

// `Slots` as in the streams. None where there are more joints than a group can name.
template <size_t Slots>
void add_groups(std::vector<Stream>& streams, const std::vector<GroupBox>& groups) {
  constexpr int kSteps = 65535;
  struct Item {
    std::array<std::uint16_t, 6> box;
    std::array<std::uint16_t, Slots> joint;
    std::array<std::uint8_t, Slots> weight;
  };
  Box all;
  for (const GroupBox& g : groups) all.add(g.box);
  float base[3], highest[3];
  all.write(base, highest);
  std::vector<Grid> grids;
  for (int c = 0; c < 3; ++c) {
    Grid& grid = grids.emplace_back(base[c], highest[c], kSteps - 2);  // two steps to spare, for rounding
    grid.base -= grid.step;
  }
  std::vector<Item> items;
  for (const GroupBox& g : groups) {
    Item& item = items.emplace_back(Item{});
    for (size_t c = 0; c < 3; ++c) {
      const int low = grids[c].nearest(g.box.min[Eigen::Index(c)], kSteps);
      const int high = grids[c].nearest(g.box.max[Eigen::Index(c)], kSteps);
      item.box[c] = std::uint16_t(std::max(low - 1, 0)),
      item.box[c + 3] = std::uint16_t(std::min(high + 1, kSteps));
    }
    for (size_t k = 0; k < g.joints.size(); ++k) {
      if (g.joints[k] > std::numeric_limits<std::uint16_t>::max()) return;
      item.joint[k] = std::uint16_t(g.joints[k]), item.weight[k] = g.weights[k];
    }
  }
  streams.push_back(stream(SLOD_GROUP, 0, items, grids));
}

// Short streams stay raw: a codec has a header and a tail.
void compress(Stream& s) {
  const slod_chunk& c = s.chunk;
  Bytes coded;
  size_t size = 0;
  if (c.kind == SLOD_INDEX) {
    std::vector<unsigned> indices(c.count);
    for (size_t i = 0; i < indices.size(); ++i) std::memcpy(&indices[i], &s.bytes[i * c.stride], c.stride);
    coded.resize(meshopt_encodeIndexBufferBound(indices.size(), indices.size()));
    meshopt_encodeIndexVersion(1);
    size = meshopt_encodeIndexBuffer(coded.data(), coded.size(), indices.data(), indices.size());
  } else {
    coded.resize(meshopt_encodeVertexBufferBound(c.count, c.stride));
    meshopt_encodeVertexVersion(0);
    size = meshopt_encodeVertexBuffer(coded.data(), coded.size(), s.bytes.data(), c.count, c.stride);
  }
  if (size >= s.bytes.size()) return;
  coded.resize(size);
  s.chunk.codec = c.kind == SLOD_INDEX ? SLOD_MESHOPT_INDEX : SLOD_MESHOPT_VERTEX;
  s.bytes = std::move(coded);
}

void require_sound(const Level& level, int index) {
  const Surface& s = level.surface;
  const auto fail = [&](const std::string& fact) {
    throw Error{Fault::Ours, "pack: level " + std::to_string(index) + ": " + fact};
  };
  if (s.face_count() == 0) fail("it has no triangles");
  if (level.max_influences < 1 || level.max_influences > SLOD_MAX_INFLUENCES) {
    fail("a cap of " + std::to_string(level.max_influences) + " influences");
  }
  for (int f = 0; f < s.face_count(); ++f) {
    if (s.face(f).size() != 3) fail("face " + std::to_string(f) + " is no triangle");
  }
  for (size_t v = 0; v < s.influences.size(); ++v) {
    const Influences& influences = s.influences[v];
    const std::string vertex = "vertex " + std::to_string(v);
    if (influences.empty() || influences.size() > size_t(level.max_influences)) {
      fail(vertex + " has " + std::to_string(influences.size()) + " influences");
    }
    const auto sound = [](const Influence& i) { return i.weight > 0 && std::isfinite(i.weight); };
    if (!std::ranges::all_of(influences, sound)) fail(vertex + " has a weight that is not above 0");
    if (!s.position[v].allFinite()) fail(vertex + " is not at a finite place");
  }
  if (!s.attributes.allFinite()) fail("an attribute is not finite");
}

slod_error as_stored(const PosedError& e) { return {float(e.rms), float(e.max)}; }

}  // namespace

std::array<double, 2> fold_octahedron(const Vec3& direction) {
  const double size = direction.lpNorm<1>();
  if (!(size > 0)) return {0, 0};
  const double x = direction.x() / size, y = direction.y() / size;
  if (direction.z() >= 0) return {x, y};
  return {(1 - std::abs(y)) * (x < 0 ? -1 : 1), (1 - std::abs(x)) * (y < 0 ? -1 : 1)};
}

PackedLevel pack_level(const Character& character, const Level& level, int index,
                       std::span<const Palette> clip_frames, const PackOptions& options) {
  require_sound(level, index);
  const Surface& surface = level.surface;
  VertexInfluences influences;
  for (const Influences& i : surface.influences) influences.push_back(round_weights(i));
  const std::vector<Section> sections = split(surface, influences);
  std::vector<int> wedges;  // of each render vertex
  for (const Section& s : sections) wedges.insert(wedges.end(), s.wedges.begin(), s.wedges.end());

  PackedLevel packed{};
  packed.streams.push_back(unorm_stream<Short4>(SLOD_POSITION, 0, 3, wedges, [&](int w, int c) {
    return surface.position[size_t(surface.wedges[size_t(w)].vertex)][c];
  }));
  const std::vector<Vec3> points = unpacked_points(packed.streams.front());
  add_attributes(packed.streams, surface, wedges);
  add_sections(packed, sections);
  if (level.max_influences > 4) {
    add_influences<std::array<std::uint8_t, 8>>(packed, sections, surface, influences);
  } else {
    add_influences<Byte4>(packed, sections, surface, influences);
  }
  const Deltas deltas = add_morphs(packed.streams, int(character.morphs.size()), surface, wedges);
  const std::vector<BoundVertex> vertices = bound_vertices(points, deltas, surface, influences, wedges);
  if (level.max_influences > 4) {
    add_groups<8>(packed.streams, group_boxes(vertices));
  } else {
    add_groups<4>(packed.streams, group_boxes(vertices));
  }
  if (!clip_frames.empty()) {
    packed.streams.push_back(stream(SLOD_CLIP_BOX, 0, std::vector{clip_box(vertices, clip_frames)}));
  }

  packed.record = {.triangle_count = std::uint32_t(surface.face_count()),
                   .vertex_count = std::uint32_t(wedges.size()),
                   .first_section = 0,
                   .section_count = std::uint32_t(sections.size()),
                   .first_chunk = 0,
                   .chunk_count = std::uint32_t(packed.streams.size()),
                   .checksum = 0,
                   .max_influences = std::uint32_t(level.max_influences),
                   .influence_slots = level.max_influences > 4 ? 8u : 4u,
                   .examples = as_stored(level.examples),
                   .unseen_clip = as_stored(level.unseen_clip),
                   .unseen_motion = as_stored(level.unseen_motion),
                   .box_min = {},
                   .box_max = {},
                   .centre = {},
                   .radius = 0};
  add_rest_bounds(packed.record, points);
  size_t first = 0, joint = 0;
  for (const Section& section : sections) {
    const auto of_section = std::span(vertices).subspan(first, section.wedges.size());
    for (const JointBox& box : joint_boxes(of_section, character.skeleton)) {
      box.box.write(packed.section_joints[joint].box_min, packed.section_joints[joint].box_max);
      ++joint;
    }
    first += section.wedges.size();
  }

  for (Stream& s : packed.streams) {
    s.chunk.level = std::uint32_t(index);
    if (options.compress && s.chunk.kind <= SLOD_MORPH_OFFSET) compress(s);
    s.chunk.bytes = std::uint32_t(s.bytes.size());
  }
  return packed;
}

}  // namespace skinlod
