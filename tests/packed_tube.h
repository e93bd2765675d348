// SPDX-License-Identifier: MIT
#pragma once

#include <doctest/doctest.h>
#include <meshoptimizer.h>
#include <Eigen/Geometry>

#include <map>
#include <utility>
#include <vector>

#include "pipeline/pack.h"
#include "runtime/slod.h"
#include "tests/shapes.h"

/// A character with every kind of stream, packed, and its levels decoded: for tests of writer and loaders.
namespace skinlod {

/// The bending tube with tangents, a second uv set, a colour set and two morphs: "bulge", which widens the
/// middle, and "still", which moves nothing. Five joints' worth of tube, so levels of any resolution fit.
inline Character decorated_tube(int around, int rings) {
  Character c = bending_tube(around, rings, 5);
  Surface& s = c.surface;
  const AttributeLayout layout{.normal = true, .tangent = true, .uv_sets = 2, .colour_sets = 1};
  Rows table(s.attributes.rows(), layout.columns());
  s.morphs.resize(s.position.size());
  s.normal_morphs.resize(s.wedges.size());
  for (size_t w = 0; w < s.wedges.size(); ++w) {
    const Eigen::Index row(w);
    const Vec3 normal = s.attributes.row(row).head<3>().transpose();
    const Vec3 x = s.position[size_t(s.wedges[w].vertex)];
    Vec3 tangent = normal.cross(Vec3(0.3, 0.5, -0.8));
    tangent.normalize();
    const double handedness = x.x() < 0 ? -1 : 1, u = s.attributes(row, 3), v = s.attributes(row, 4);
    table.row(row) << normal.transpose(), tangent.transpose(), handedness, u, v, 3 * v - 1, 2 - u, u, v, 0.25,
        1;
    if (x.y() < 1 || x.y() > 4) continue;
    s.morphs[size_t(s.wedges[w].vertex)] = {{0, Vec3(x.x(), -0.1, x.z()) * 0.3}};
    s.normal_morphs[w] = {{0, Vec3(0, 0.01 * x.y(), -0.2)}};
  }
  s.layout = layout, s.attributes = table;
  c.parts[0].has = layout;
  c.morphs = {{.name = "bulge", .node = 5, .weight = 0.25}, {.name = "still", .node = 5}};
  return c;
}

inline Level as_level(Surface surface, int max_influences, double error) {
  Level level{.surface = std::move(surface), .max_influences = max_influences};
  level.asked = level.surface.face_count();
  level.examples = {.rms = error / 4, .max = error};
  level.unseen_clip = {.rms = error / 3, .max = error * 1.25};
  level.unseen_motion = {.rms = error / 2, .max = error * 2};
  return level;
}

/// Three levels, finest first, with errors of 0, 1 cm and 4 cm over the example poses.
inline std::vector<Level> tube_levels() {
  return {as_level(decorated_tube(12, 10).surface, 4, 0), as_level(decorated_tube(8, 5).surface, 4, 0.01),
          as_level(decorated_tube(4, 3).surface, 2, 0.04)};
}

inline std::vector<std::byte> packed_tube(const PackOptions& options = {}) {
  return pack(decorated_tube(12, 10), tube_levels(), options);
}

inline constexpr slod_codecs kMeshoptimizer{meshopt_decodeVertexBuffer, meshopt_decodeIndexBuffer};

inline slod_file opened(const std::vector<std::byte>& bytes) {
  slod_file file;
  REQUIRE(slod_open(bytes.data(), bytes.size(), &file) == SLOD_OK);
  return file;
}

/// One stream as an array of Item.
template <class Item>
std::vector<Item> decoded(const slod_file& file, std::uint32_t level, slod_kind kind, std::uint32_t set = 0) {
  const std::uint32_t index = slod_find(&file, level, kind, set);
  REQUIRE(index != SLOD_NONE);
  const slod_chunk c = slod_get_chunk(&file, index);
  std::vector<Item> items(size_t(c.count) * c.stride / sizeof(Item));
  REQUIRE(slod_decode(&file, index, &kMeshoptimizer, items.data(), items.size() * sizeof(Item)) == SLOD_OK);
  return items;
}

/// One stream as floats.
inline std::vector<float> unpacked(const slod_file& file, std::uint32_t level, slod_kind kind,
                                   std::uint32_t set = 0) {
  const auto bytes = decoded<std::uint8_t>(file, level, kind, set);
  const slod_chunk c = slod_get_chunk(&file, slod_find(&file, level, kind, set));
  std::vector<float> values(size_t(c.count) * slod_components(&c));
  slod_unpack(&c, bytes.data(), values.data());
  return values;
}

inline std::vector<std::uint32_t> decoded_indices(const slod_file& file, std::uint32_t level) {
  if (slod_get_chunk(&file, slod_find(&file, level, SLOD_INDEX, 0)).stride == 4) {
    return decoded<std::uint32_t>(file, level, SLOD_INDEX);
  }
  const auto narrow = decoded<std::uint16_t>(file, level, SLOD_INDEX);
  return {narrow.begin(), narrow.end()};
}

inline Vec3 point(const std::vector<float>& values, size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

}  // namespace skinlod
