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
#include <set>
#include <string>

#include "pipeline/error.h"

namespace skinlod {
namespace {

struct ByteInfluence {
  int joint;
  std::uint8_t weight;
};

// Weights as 255ths that sum to 255, by largest remainder; heaviest first, ties by joint. Done once per
// vertex, before any section: so all its wedges blend the same joints by the same weights in the same order,
// and cannot come apart.
std::vector<ByteInfluence> round_weights(const Influences& influences) {
  struct Share {
    int joint, whole;
    double rest;
  };
  double sum = 0;
  for (const Influence& i : influences) sum += i.weight;
  std::vector<Share> shares;
  int left = 255;
  for (const Influence& i : influences) {
    const double exact = i.weight / sum * 255;
    const int whole = int(exact);
    shares.push_back({i.joint, whole, exact - whole});
    left -= whole;
  }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const Share& a, const Share& b) { return a.rest > b.rest; });
  for (int i = 0; i < left; ++i) ++shares[size_t(i) % shares.size()].whole;

  std::vector<ByteInfluence> rounded;
  for (const Share& s : shares) {
    if (s.whole > 0) rounded.push_back({s.joint, std::uint8_t(s.whole)});
  }
  std::sort(rounded.begin(), rounded.end(), [](const ByteInfluence& a, const ByteInfluence& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.joint < b.joint;
  });
  return rounded;
}

// Row per vertex.
using VertexInfluences = std::vector<std::vector<ByteInfluence>>;

struct Section {
  int part;
  std::set<int> joints{};
  std::vector<int> wedges{};        // one per corner; once ordered, one per render vertex
  std::vector<unsigned> indices{};  // into `wedges`, once ordered
};

// Each triangle goes to the first section of its part that has room for its joints.
std::vector<Section> split(const Surface& surface, const VertexInfluences& influences) {
  std::map<int, std::vector<Section>> sections;  // of each part
  for (int f = 0; f < surface.face_count(); ++f) {
    std::set<int> joints;
    for (const int w : surface.face(f)) {
      for (const auto& i : influences[size_t(surface.wedges[size_t(w)].vertex)]) joints.insert(i.joint);
    }
    const auto has_room = [&](const Section& s) {
      const auto fresh = std::ranges::count_if(joints, [&](int j) { return !s.joints.contains(j); });
      return s.joints.size() + size_t(fresh) <= SLOD_MAX_SECTION_JOINTS;
    };
    std::vector<Section>& open = sections[surface.part(f)];
    auto section = std::ranges::find_if(open, has_room);
    if (section == open.end()) section = open.insert(open.end(), {.part = surface.part(f)});
    section->joints.insert(joints.begin(), joints.end());
    for (const int w : surface.face(f)) section->wedges.push_back(w);
  }
  std::vector<Section> all;
  for (auto& [part, of_part] : sections) std::ranges::move(of_part, std::back_inserter(all));
  return all;
}

// Triangles in the order that reuses vertices best, vertices in the order in which they are fetched. Overdraw
// is left alone: an order that is good at rest says little about other poses.
void order(Section& s) {
  std::map<int, unsigned> place;
  for (const int w : s.wedges) {
    s.indices.push_back(place.try_emplace(w, unsigned(place.size())).first->second);
  }
  const size_t vertices = place.size();
  std::vector<unsigned> remap(vertices);
  meshopt_optimizeVertexCache(s.indices.data(), s.indices.data(), s.indices.size(), vertices);
  meshopt_optimizeVertexFetchRemap(remap.data(), s.indices.data(), s.indices.size(), vertices);
  for (unsigned& i : s.indices) i = remap[i];
  s.wedges.resize(vertices);
  for (const auto& [w, i] : place) s.wedges[remap[i]] = w;
}

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

// Where a direction meets the octahedron |x| + |y| + |z| = 1, its lower half folded outwards: Meyer et al.
// 2010, "On Floating-Point Normal Vectors". A direction without length is +z.
std::array<double, 2> fold_octahedron(const Vec3& direction) {
  const double size = direction.lpNorm<1>();
  if (!(size > 0)) return {0, 0};
  const double x = direction.x() / size, y = direction.y() / size;
  if (direction.z() >= 0) return {x, y};
  return {(1 - std::abs(y)) * (x < 0 ? -1 : 1), (1 - std::abs(x)) * (y < 0 ? -1 : 1)};
}

// The floats next below and above, so that rounding lets no point out of its box.
float below(double x) { return std::nextafter(float(x), -std::numeric_limits<float>::infinity()); }
float above(double x) { return std::nextafter(float(x), std::numeric_limits<float>::infinity()); }

struct Box {
  Vec3 min = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 max = -min;

  void add(const Vec3& lowest, const Vec3& highest) {
    min = min.cwiseMin(lowest), max = max.cwiseMax(highest);
  }
  void write(float* lowest, float* highest) const {
    for (int i = 0; i < 3; ++i) lowest[i] = below(min[i]), highest[i] = above(max[i]);
  }
};

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
      packed.sections[s].max_influences = std::max(packed.sections[s].max_influences, slot);
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
                               .max_influences = 0});
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

// What can move one render vertex, unpacked.
using Deltas = std::vector<std::vector<Vec3>>;

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

void add_bounds(slod_level& record, const std::vector<Vec3>& points) {
  Box box;
  for (const Vec3& x : points) box.add(x, x);
  box.write(record.box_min, record.box_max);
  for (int i = 0; i < 3; ++i) record.centre[i] = float((box.min[i] + box.max[i]) / 2);
  const Vec3 centre(record.centre[0], record.centre[1], record.centre[2]);
  for (const Vec3& x : points) record.radius = std::max(record.radius, above((x - centre).norm()));
}

// Morphs at weights from 0 to 1 add at least the sum of all that is negative, at most of all that is
// positive.
void add_joint_boxes(PackedLevel& packed, const std::vector<Section>& sections, const Surface& surface,
                     const VertexInfluences& influences, const std::vector<Vec3>& points,
                     const Deltas& deltas, const Skeleton& skeleton) {
  size_t v = 0;
  auto packed_joint = packed.section_joints.begin();
  for (const Section& s : sections) {
    std::map<int, Box> boxes;
    for (const int w : s.wedges) {
      for (const ByteInfluence& i : influences[size_t(surface.wedges[size_t(w)].vertex)]) {
        const Affine& bind = skeleton.joints[size_t(i.joint)].inverse_bind;
        Vec3 lowest = transform(bind, points[v]), highest = lowest;
        for (const Vec3& delta : deltas[v]) {
          const Vec3 turned = bind.leftCols<3>() * delta;
          lowest += turned.cwiseMin(0.0), highest += turned.cwiseMax(0.0);
        }
        boxes[i.joint].add(lowest, highest);
      }
      ++v;
    }
    for (const auto& [joint, box] : boxes) {
      box.write(packed_joint->box_min, packed_joint->box_max);
      ++packed_joint;
    }
  }
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

PackedLevel pack_level(const Character& character, const Level& level, int index,
                       const PackOptions& options) {
  require_sound(level, index);
  const Surface& surface = level.surface;
  VertexInfluences influences;
  for (const Influences& i : surface.influences) influences.push_back(round_weights(i));
  std::vector<Section> sections = split(surface, influences);
  std::vector<int> wedges;  // of each render vertex
  for (Section& s : sections) {
    order(s);
    wedges.insert(wedges.end(), s.wedges.begin(), s.wedges.end());
  }

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
  add_bounds(packed.record, points);
  add_joint_boxes(packed, sections, surface, influences, points, deltas, character.skeleton);

  for (Stream& s : packed.streams) {
    s.chunk.level = std::uint32_t(index);
    if (options.compress) compress(s);
    s.chunk.bytes = std::uint32_t(s.bytes.size());
  }
  return packed;
}

}  // namespace skinlod
