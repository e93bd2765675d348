// SPDX-License-Identifier: MIT
#include "runtime/slod.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <set>
#include <string>

#include "tests/packed_tube.h"

extern "C" int slod_c99_loads(const void* bytes, size_t size, uint32_t* triangles);

namespace skinlod {
namespace {

slod_status open_status(const std::vector<std::byte>& bytes, size_t size) {
  slod_file file;
  // A copy of the exact size, so that a sanitizer sees every access beyond it.
  const std::vector<std::byte> prefix(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));
  const slod_status status = slod_open(prefix.data(), prefix.size(), &file);
  if (status != SLOD_OK) CHECK((file.level_count == 0 && slod_count(&file, SLOD_NODES) == 0));
  return status;
}

// The matrices of the rest pose; `bend` turns every joint but the root by a quarter about z.
struct MatrixSet {
  std::vector<float> globals, palette;
};

MatrixSet posed(const slod_file& file, bool bend) {
  MatrixSet pose;
  pose.globals.resize(12 * size_t(slod_count(&file, SLOD_NODES)));
  pose.palette.resize(12 * size_t(slod_count(&file, SLOD_JOINTS)));
  slod_rest_locals(&file, pose.globals.data());
  for (std::uint32_t n = 0; bend && n < slod_count(&file, SLOD_NODES); ++n) {
    const slod_node node = slod_get_node(&file, n);
    if (node.parent < 0) continue;
    const float turned[12] = {0, -1, 0, node.translation[0], 1, 0, 0, node.translation[1],
                              0, 0,  1, node.translation[2]};
    std::memcpy(pose.globals.data() + 12 * size_t(n), turned, sizeof turned);
  }
  slod_globals(&file, pose.globals.data(), pose.globals.data());
  slod_palette(&file, pose.globals.data(), pose.palette.data());
  return pose;
}

slod_view view_at(float distance, float hysteresis = 0.2f) {
  return {.distance = distance,
          .projection_scale = 1.5f,
          .viewport_height = 1080,
          .pixel_tolerance = 1,
          .hysteresis = hysteresis,
          .model_scale = 1};
}

}  // namespace

TEST_SUITE("slod") {
  TEST_CASE("the checksum is XXH64 as libxxhash computes it") {
    std::mt19937 random(1);
    std::vector<std::uint8_t> bytes(300);
    for (auto& b : bytes) b = std::uint8_t(random());
    for (size_t size = 0; size <= bytes.size(); ++size) {
      CAPTURE(size);
      CHECK(slod_checksum(bytes.data(), size) == XXH64(bytes.data(), size, 0));
    }
  }

  TEST_CASE("every status has a sentence of its own") {
    std::set<std::string> texts;
    for (int s = SLOD_OK; s <= SLOD_BAD_ARGUMENT; ++s) texts.insert(slod_status_text(slod_status(s)));
    CHECK(texts.size() == SLOD_BAD_ARGUMENT + 1);
    CHECK_FALSE(texts.contains(slod_status_text(slod_status(SLOD_BAD_ARGUMENT + 1))));
  }

  TEST_CASE("a C99 program can use the header") {
    const auto bytes = packed_tube();
    std::uint32_t triangles = 0;
    CHECK(slod_c99_loads(bytes.data(), bytes.size(), &triangles) == 1);
    CHECK(triangles == std::uint32_t(tube_levels()[0].surface.face_count()));
  }

  TEST_CASE("magic and version and byte order and size are told apart") {
    const auto good = packed_tube();
    CHECK(open_status(good, good.size()) == SLOD_OK);
    const auto with = [&](size_t at, int value) {
      auto bytes = good;
      bytes[at] = std::byte(value);
      return open_status(bytes, bytes.size());
    };
    CHECK(with(0, 'X') == SLOD_NOT_SLOD);
    CHECK(with(offsetof(slod_header, version), 2) == SLOD_OTHER_VERSION);
    CHECK(with(offsetof(slod_header, endian), 1) == SLOD_OTHER_ENDIAN);
    CHECK(with(offsetof(slod_header, checksum), 77) == SLOD_BAD_CHECKSUM);
    CHECK(with(sizeof(slod_header), 77) == SLOD_BAD_CHECKSUM);
    CHECK(with(good.size() - 1, 77) == SLOD_BAD_CHECKSUM);

    auto longer = good;
    longer.push_back({});
    CHECK(open_status(longer, longer.size()) == SLOD_TRAILING_BYTES);
    slod_file file;
    CHECK(slod_open(nullptr, 5, &file) == SLOD_BAD_ARGUMENT);
    CHECK(slod_open(good.data(), good.size(), nullptr) == SLOD_BAD_ARGUMENT);
  }

  TEST_CASE("no true prefix of a file opens as the whole file") {
    const auto bytes = packed_tube();
    for (size_t size = 0; size < bytes.size(); ++size) {
      CAPTURE(size);
      REQUIRE(open_status(bytes, size) == SLOD_TRUNCATED);
    }
  }

  TEST_CASE("a prefix holds the coarse levels bit for bit") {
    const auto bytes = packed_tube();
    const slod_file whole = opened(bytes);
    slod_header header;
    std::memcpy(&header, bytes.data(), sizeof header);
    REQUIRE(whole.level_count == 3);
    CHECK(header.head_bytes < slod_prefix_bytes(&whole, 2));
    CHECK(slod_prefix_bytes(&whole, 2) < slod_prefix_bytes(&whole, 1));
    CHECK(slod_prefix_bytes(&whole, 1) < slod_prefix_bytes(&whole, 0));
    CHECK(slod_prefix_bytes(&whole, 0) == bytes.size());

    for (size_t size = 0; size <= bytes.size(); ++size) {
      CAPTURE(size);
      const std::vector<std::byte> prefix(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));
      slod_file file;
      const slod_status status = slod_open_prefix(prefix.data(), prefix.size(), &file);
      if (size < header.head_bytes) {
        REQUIRE(status == SLOD_TRUNCATED);
        continue;
      }
      REQUIRE(status == SLOD_OK);
      std::uint32_t finest = 3;
      while (finest > 0 && slod_prefix_bytes(&whole, finest - 1) <= size) --finest;
      REQUIRE(file.first_level == finest);
      if (size % 64 != 0) continue;
      for (std::uint32_t level = 0; level < 3; ++level) {
        const std::uint32_t chunk = slod_find(&file, level, SLOD_POSITION, 0);
        const auto expected = decoded<std::uint16_t>(whole, level, SLOD_POSITION);
        std::vector<std::uint16_t> got(expected.size());
        const slod_status decoding = slod_decode(&file, chunk, &kMeshoptimizer, got.data(), got.size() * 2);
        CHECK(decoding == (level < finest ? SLOD_LEVEL_ABSENT : SLOD_OK));
        CHECK((got == expected) == (level >= finest));
      }
    }
  }

  TEST_CASE("a flipped bit anywhere is noticed") {
    auto bytes = packed_tube();
    slod_file file;
    size_t noticed = 0;
    for (size_t bit = 0; bit < 8 * bytes.size(); bit += 1 + bit / 4096) {
      const std::byte mask{std::uint8_t(1 << bit % 8)};
      bytes[bit / 8] ^= mask;
      CAPTURE(bit);
      REQUIRE(slod_open(bytes.data(), bytes.size(), &file) != SLOD_OK);
      bytes[bit / 8] ^= mask;
      ++noticed;
    }
    CHECK(noticed > 10000);
    CHECK(slod_open(bytes.data(), bytes.size(), &file) == SLOD_OK);
  }

  TEST_CASE("a stream needs its codec and a buffer of its size") {
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    for (const slod_kind kind : {SLOD_POSITION, SLOD_INDEX}) {
      const std::uint32_t index = slod_find(&file, 0, kind, 0);
      const slod_chunk chunk = slod_get_chunk(&file, index);
      const size_t size = size_t(chunk.count) * chunk.stride;
      std::vector<std::uint8_t> buffer(size);
      const slod_codecs none{};
      CHECK(slod_decode(&file, index, &kMeshoptimizer, buffer.data(), size) == SLOD_OK);
      CHECK(slod_decode(&file, index, &kMeshoptimizer, buffer.data(), size - 1) == SLOD_BUFFER_TOO_SMALL);
      CHECK(slod_decode(&file, index, &none, buffer.data(), size) == SLOD_NO_CODEC);
      CHECK(slod_decode(&file, index, nullptr, buffer.data(), size) == SLOD_NO_CODEC);
      CHECK(slod_decode(&file, index, &kMeshoptimizer, nullptr, size) == SLOD_BAD_ARGUMENT);
      CHECK(slod_decode(&file, file.chunk_count, &kMeshoptimizer, buffer.data(), size) == SLOD_BAD_ARGUMENT);
      CHECK(slod_decode(&file, SLOD_NODES, &kMeshoptimizer, buffer.data(), size) == SLOD_BAD_ARGUMENT);
    }
    const auto raw = packed_tube({.compress = false});
    const slod_file plain = opened(raw);
    std::vector<std::uint16_t> positions(4 * size_t(slod_get_level(&plain, 0).vertex_count));
    const std::uint32_t index = slod_find(&plain, 0, SLOD_POSITION, 0);
    CHECK(slod_decode(&plain, index, nullptr, positions.data(), positions.size() * 2) == SLOD_OK);
    CHECK(positions == decoded<std::uint16_t>(file, 0, SLOD_POSITION));
  }

  TEST_CASE("what is not there reads as zero") {
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    CHECK(slod_find(&file, 0, SLOD_UV, 2) == SLOD_NONE);
    CHECK(slod_find(&file, 3, SLOD_POSITION, 0) == SLOD_NONE);
    CHECK(slod_get_level(&file, 3).vertex_count == 0);
    CHECK(slod_get_section(&file, SLOD_NONE).index_count == 0);
    CHECK(slod_get_chunk(&file, SLOD_NONE).bytes == 0);
    CHECK(slod_prefix_bytes(&file, 3) == 0);
    CHECK(std::string(slod_name(&file, SLOD_NONE)).empty());
    CHECK(std::string(slod_name(&file, slod_get_node(&file, 1).name)) == "joint1");
  }

  TEST_CASE("the rest pose is the identity palette") {
    const auto bytes = packed_tube();
    const MatrixSet rest = posed(opened(bytes), false);
    for (size_t i = 0; i < rest.palette.size(); ++i) {
      CHECK(rest.palette[i] == doctest::Approx(i % 12 % 5 == 0 ? 1 : 0).epsilon(1e-6));
    }
  }

  TEST_CASE("what a level needs is enough to pose it and no more") {
    std::vector<Level> levels = {tube_levels()[0], tube_levels()[1]};
    for (Influences& i : levels[1].surface.influences) i = {{2, 1.0}};
    const auto bytes = pack(decorated_tube(12, 10), levels);
    const slod_file file = opened(bytes);
    using Flags = std::vector<std::uint8_t>;
    const auto needed = [&](std::uint32_t level, Flags nodes) {
      Flags joints(slod_count(&file, SLOD_JOINTS), 0);
      slod_needed(&file, level, joints.data(), nodes.data());
      return std::pair(joints, nodes);
    };
    CHECK(needed(0, Flags(6, 0)) == std::pair(Flags{1, 1, 1, 1, 1}, Flags{1, 1, 1, 1, 1, 0}));
    CHECK(needed(1, Flags(6, 0)) == std::pair(Flags{0, 0, 1, 0, 0}, Flags{1, 1, 1, 0, 0, 0}));
    CHECK(needed(1, {0, 0, 0, 1, 0, 0}) == std::pair(Flags{0, 0, 1, 0, 0}, Flags{1, 1, 1, 1, 0, 0}));

    // The palette of the other joints may be anything.
    const auto [joints, nodes] = needed(1, Flags(6, 0));
    std::vector<float> palette = posed(file, true).palette;
    const auto skinned = [&] {
      std::vector<float> x = unpacked(file, 1, SLOD_POSITION);
      slod_skin(&file, 1, decoded<std::uint8_t>(file, 1, SLOD_JOINT_INDEX).data(),
                decoded<std::uint8_t>(file, 1, SLOD_WEIGHT).data(), palette.data(), x.data(), nullptr);
      return x;
    };
    const std::vector<float> whole = skinned();
    for (size_t j = 0; j < joints.size(); ++j) {
      if (!joints[j]) std::fill_n(palette.begin() + std::ptrdiff_t(12 * j), 12, 1e6f);
    }
    CHECK(skinned() == whole);
    std::fill_n(palette.begin() + 24, 12, 1e6f);
    CHECK(skinned() != whole);
  }
  TEST_CASE("skinned normals stay across the surface under uneven scale and mirrors") {
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    const auto joints = decoded<std::uint8_t>(file, 0, SLOD_JOINT_INDEX);
    const auto weights = decoded<std::uint8_t>(file, 0, SLOD_WEIGHT);
    for (const float side : {1.0f, -1.0f}) {
      // All joints at once: x is stretched three times, or mirrored too.
      std::vector<float> palette;
      for (std::uint32_t j = 0; j < slod_count(&file, SLOD_JOINTS); ++j) {
        palette.insert(palette.end(), {3 * side, 0, 0, 7, 0, 1, 0, 0, 0, 0, 1, 0});
      }
      const auto rest_normals = unpacked(file, 0, SLOD_NORMAL), rest = unpacked(file, 0, SLOD_POSITION);
      auto x = rest, n = rest_normals;
      slod_skin(&file, 0, joints.data(), weights.data(), palette.data(), x.data(), n.data());
      for (size_t v = 0; v < x.size() / 3; ++v) {
        Vec3 expected = point(rest_normals, v);
        expected.x() *= side / 3;
        CHECK((point(n, v) - expected.normalized()).norm() < 1e-5);
        CHECK((point(x, v) - Vec3(3 * side * rest[3 * v] + 7, rest[3 * v + 1], rest[3 * v + 2])).norm() <
              1e-5);
      }
    }
  }

  TEST_CASE("the posed bounds hold every posed vertex with morphs on and are not loose at rest") {
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    for (std::uint32_t level = 0; level < file.level_count; ++level) {
      for (const bool bend : {false, true}) {
        const MatrixSet pose = posed(file, bend);
        auto x = unpacked(file, level, SLOD_POSITION);
        const auto joints = decoded<std::uint8_t>(file, level, SLOD_JOINT_INDEX);
        const auto weights = decoded<std::uint8_t>(file, level, SLOD_WEIGHT);
        if (bend) {
          const slod_chunk chunk = slod_get_chunk(&file, slod_find(&file, level, SLOD_MORPH_OFFSET, 0));
          const float on[2] = {1, 1};
          slod_add_morphs(&file, &chunk, decoded<std::uint32_t>(file, level, SLOD_MORPH_RANGE).data(),
                          decoded<slod_morph_offset>(file, level, SLOD_MORPH_OFFSET).data(), on, x.data(),
                          nullptr);
        }
        slod_skin(&file, level, joints.data(), weights.data(), pose.palette.data(), x.data(), nullptr);
        float lowest[3], highest[3];
        slod_posed_bounds(&file, level, pose.globals.data(), lowest, highest);
        const slod_level l = slod_get_level(&file, level);
        for (size_t i = 0; i < x.size(); ++i) {
          CHECK(x[i] >= lowest[i % 3] - 1e-5f);
          CHECK(x[i] <= highest[i % 3] + 1e-5f);
          if (!bend) {
            CHECK(x[i] >= l.box_min[i % 3] - 1e-5f);
            CHECK(x[i] <= l.box_max[i % 3] + 1e-5f);
          }
        }
        for (size_t v = 0; !bend && v < x.size() / 3; ++v) {
          CHECK((point(x, v) - Vec3(l.centre[0], l.centre[1], l.centre[2])).norm() <=
                double(l.radius) + 1e-5);
        }
        for (int i = 0; !bend && i < 3; ++i) {
          CHECK(highest[i] - lowest[i] < 1.5f * (l.box_max[i] - l.box_min[i]));
        }
      }
    }
  }

  TEST_CASE("the error in pixels is that of the projection") {
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    // 5 cm (the larger of examples and clips), 10 m away, 1080 pixels for 2 / 1.5 of the distance.
    const slod_view view = view_at(10);
    CHECK(slod_pixel_error(&file, 2, &view) == doctest::Approx(0.05 / 10 * 1080 * 1.5 / 2));
    CHECK(slod_pixel_error(&file, 0, &view) == 0);
  }

  TEST_CASE("the level chosen is the coarsest that stays within the tolerance") {
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    for (const float distance : {0.0f, 0.5f, 5.0f, 10.0f, 20.0f, 40.0f, 41.0f, 1e6f}) {
      CAPTURE(distance);
      const slod_view view = view_at(distance);
      const std::uint32_t chosen = slod_select_level(&file, &view, SLOD_NONE);
      CHECK((chosen == 0 || slod_pixel_error(&file, chosen, &view) <= 1));
      if (chosen < 2) CHECK(slod_pixel_error(&file, chosen + 1, &view) > 1);
    }
    const slod_view near = view_at(0), far = view_at(1e6f);
    CHECK(slod_select_level(&file, &near, SLOD_NONE) == 0);
    CHECK(slod_select_level(&file, &far, SLOD_NONE) == 2);
  }

  TEST_CASE("with hysteresis a choice is kept until it is clearly wrong and then does not come back") {
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    const auto sweep = [&](const auto& distances, std::uint32_t level) {
      std::vector<std::pair<float, std::uint32_t>> switches;
      for (const float d : distances) {
        const slod_view view = view_at(d);
        const std::uint32_t next = slod_select_level(&file, &view, level);
        CHECK(slod_select_level(&file, &view, next) == next);  // settled at once
        CHECK(slod_pixel_error(&file, next, &view) <= (next == 0 ? 1e9f : 1.2f + 1e-5f));
        if (next != level) switches.push_back({d, next});
        level = next;
      }
      return switches;
    };
    std::vector<float> away;
    for (float d = 1; d < 100; d *= 1.001f) away.push_back(d);
    const auto out = sweep(away, 0);
    std::reverse(away.begin(), away.end());
    const auto in = sweep(away, 2);
    REQUIRE(out.size() == 2);
    REQUIRE(in.size() == 2);
    // Out at 1 / (1 - 0.2) times the distance where the error is one pixel, in at 1 / (1 + 0.2) times it.
    const double metres[] = {0.0125 * 1080 * 1.5 / 2, 0.05 * 1080 * 1.5 / 2};
    for (size_t i = 0; i < 2; ++i) {
      CHECK(out[i].second == i + 1);
      CHECK(out[i].first == doctest::Approx(metres[i] / 0.8).epsilon(0.002));
      CHECK(in[1 - i].second == i);
      CHECK(in[1 - i].first == doctest::Approx(metres[i] / 1.2).epsilon(0.002));
    }
  }

  TEST_CASE("of a prefix only levels that are there are chosen") {
    const auto bytes = packed_tube();
    const slod_file whole = opened(bytes);
    const slod_view near = view_at(0.1f);
    for (std::uint32_t level = 0; level < 3; ++level) {
      slod_file file;
      REQUIRE(slod_open_prefix(bytes.data(), slod_prefix_bytes(&whole, level), &file) == SLOD_OK);
      CHECK(slod_select_level(&file, &near, SLOD_NONE) == level);
      CHECK(slod_select_level(&file, &near, 0) == level);
    }
    slod_header header;
    std::memcpy(&header, bytes.data(), sizeof header);
    slod_file head;
    REQUIRE(slod_open_prefix(bytes.data(), header.head_bytes, &head) == SLOD_OK);
    CHECK(slod_select_level(&head, &near, SLOD_NONE) == SLOD_NONE);
  }
}

}  // namespace skinlod
