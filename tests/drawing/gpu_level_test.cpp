// SPDX-License-Identifier: MIT
#include "tools/drawing/gpu_level.h"

#include <random>

#include "tests/packed_tube.h"
#include "tests/random.h"
#include "tools/drawing/offscreen.h"
#include "tools/drawing/renderer.h"

namespace skinlod {
namespace {

// Joints turned, stretched, mirrored and moved at random.
std::vector<float> random_palette(const slod_file& file, unsigned seed) {
  std::mt19937 random(seed);
  Palette palette;
  for (std::uint32_t j = 0; j < slod_count(&file, SLOD_JOINTS); ++j) {
    Affine& m = palette.emplace_back();
    for (int c = 0; c < 4; ++c) m.col(c) = random_vector(random, 1);
  }
  return packed(palette);
}

// The level as the loader's own functions pose it.
GpuLevel::Posed skinned(const slod_file& file, std::uint32_t level, std::span<const float> palette,
                        std::span<const float> morphs) {
  GpuLevel::Posed posed{unpacked(file, level, SLOD_POSITION), unpacked(file, level, SLOD_NORMAL)};
  if (!morphs.empty()) {
    const slod_chunk chunk = slod_get_chunk(&file, slod_find(&file, level, SLOD_MORPH_OFFSET, 0));
    slod_add_morphs(&file, &chunk, decoded<std::uint32_t>(file, level, SLOD_MORPH_RANGE).data(),
                    decoded<slod_morph_offset>(file, level, SLOD_MORPH_OFFSET).data(), morphs.data(),
                    posed.positions.data(), posed.normals.data());
  }
  slod_skin(&file, level, decoded<std::uint8_t>(file, level, SLOD_JOINT_INDEX).data(),
            decoded<std::uint8_t>(file, level, SLOD_WEIGHT).data(), palette.data(), posed.positions.data(),
            posed.normals.data());
  return posed;
}

double largest_difference(const std::vector<float>& a, const std::vector<float>& b) {
  REQUIRE(a.size() == b.size());
  REQUIRE(!a.empty());
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(double(a[i]) - double(b[i])));
  return largest;
}

// The tube with eight influences everywhere.
std::vector<std::byte> eight_influences() {
  Character c = bending_tube(12, 6, 8);
  for (size_t v = 0; v < c.surface.position.size(); ++v) {
    Influences& influences = c.surface.influences[v];
    influences.clear();
    for (int j = 0; j < 8; ++j) influences.push_back({j, double(1 + (size_t(j) + v) % 8) / 36});
  }
  const std::array levels = {as_level(c.surface, 8, 0)};
  return pack(c, levels);
}

// How many pixels of a picture of the tube have the colour of inner sides, and how many are no background.
struct Seen {
  int red = 0, any = 0;
};

Seen seen(const std::vector<std::byte>& bytes) {
  const slod_file file = opened(bytes);
  const Offscreen offscreen;
  Renderer renderer(file, {}, 96, 96);
  const std::vector<float> rest = packed(Palette(slod_count(&file, SLOD_JOINTS), identity()));
  std::vector<Vec3> points;
  const std::vector<float> x = unpacked(file, 0, SLOD_POSITION);
  for (size_t v = 0; v < x.size() / 3; ++v) points.push_back(point(x, v));
  const Picture picture = renderer.draw(GpuLevel(file, 0), rest, View::around(points, 30));
  Seen pixels;
  for (size_t i = 0; i < picture.bytes.size(); i += 3) {
    const int r = picture.bytes[i], g = picture.bytes[i + 1], b = picture.bytes[i + 2];
    pixels.red += r > 2 * g && r > 2 * b;
    pixels.any += !std::equal(picture.bytes.begin(), picture.bytes.begin() + 3,
                              picture.bytes.begin() + std::ptrdiff_t(i));
  }
  return pixels;
}

}  // namespace

TEST_SUITE("drawing") {
  TEST_CASE("the shader poses as slod_skin does") {
    const Offscreen offscreen;
    for (const auto& bytes : {packed_tube(), eight_influences()}) {
      const slod_file file = opened(bytes);
      for (std::uint32_t level = 0; level < file.level_count; ++level) {
        CAPTURE(level);
        const auto palette = random_palette(file, 1 + level);
        const auto shader = GpuLevel(file, level).posed(palette);
        const auto loader = skinned(file, level, palette, {});
        CHECK(largest_difference(shader.positions, loader.positions) < 1e-4);
        CHECK(largest_difference(shader.normals, loader.normals) < 1e-3);
        const auto other = skinned(file, level, random_palette(file, 99), {});
        CHECK(largest_difference(shader.positions, other.positions) > 0.1);
        CHECK(largest_difference(shader.normals, other.normals) > 0.1);
      }
    }
  }

  TEST_CASE("a level drawn with morphs is the one that slod_add_morphs gives") {
    const Offscreen offscreen;
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    const auto palette = random_palette(file, 5);
    const std::vector<float> bulge = {0.7f, 0.2f}, none = {0, 0};
    const auto shader = GpuLevel(file, 0, bulge).posed(palette);
    const auto loader = skinned(file, 0, palette, bulge);
    CHECK(largest_difference(shader.positions, loader.positions) < 1e-4);
    CHECK(largest_difference(shader.normals, loader.normals) < 1e-3);
    CHECK(largest_difference(shader.positions, skinned(file, 0, palette, none).positions) > 0.05);
  }

  TEST_CASE("a picture shows a closed surface from outside, and what is inside out in red") {
    Character c = bending_tube(24, 6, 4);
    const std::array outside = {as_level(c.surface, 4, 0)};
    const Seen good = seen(pack(c, outside));
    for (int f = 0; f < c.surface.face_count(); ++f) {
      std::swap(c.surface.corners[size_t(3 * f)], c.surface.corners[size_t(3 * f + 1)]);
    }
    const std::array inside_out = {as_level(c.surface, 4, 0)};
    const Seen bad = seen(pack(c, inside_out));
    CHECK(good.any > 96 * 96 / 4);
    CHECK(good.red == 0);
    CHECK(bad.any == good.any);
    CHECK(bad.red > bad.any / 2);
  }
}

}  // namespace skinlod
