// SPDX-License-Identifier: MIT
#include "pipeline/pack.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "pipeline/error.h"
#include "tests/packed_tube.h"

namespace skinlod {
namespace {

// For each render vertex the source's wedge that it came from: the nearest by position and attributes.
std::vector<int> sources(const slod_file& file, std::uint32_t level, const Surface& surface) {
  const auto x = unpacked(file, level, SLOD_POSITION), n = unpacked(file, level, SLOD_NORMAL);
  const auto uv = unpacked(file, level, SLOD_UV, 0);
  std::vector<int> source;
  for (size_t i = 0; i < x.size() / 3; ++i) {
    const auto distance = [&](const Wedge& wedge) {
      const auto row = surface.attributes.row(Eigen::Index(&wedge - surface.wedges.data()));
      const Vec2 at(uv[2 * i], uv[2 * i + 1]);
      return (surface.position[size_t(wedge.vertex)] - point(x, i)).norm() +
             (row.head<3>().transpose() - point(n, i)).norm() +
             (row.segment<2>(surface.layout.uv_at(0)).transpose() - at).norm();
    };
    const auto nearest = std::ranges::min_element(surface.wedges, {}, distance);
    REQUIRE(distance(*nearest) < 1e-3);
    source.push_back(int(nearest - surface.wedges.begin()));
  }
  return source;
}

slod_chunk chunk_of(const slod_file& file, std::uint32_t level, slod_kind kind, std::uint32_t set = 0) {
  return slod_get_chunk(&file, slod_find(&file, level, kind, set));
}

// A triangle begins at its smallest corner: the index codec turns triangles.
std::array<int, 3> turned(std::array<int, 3> t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

std::vector<std::array<int, 3>> triangles(const Surface& surface) {
  std::vector<std::array<int, 3>> all;
  for (int f = 0; f < surface.face_count(); ++f) {
    all.push_back(turned({surface.face(f)[0], surface.face(f)[1], surface.face(f)[2]}));
  }
  std::ranges::sort(all);
  return all;
}

std::array<std::uint8_t, 4> packed_weights(const Influences& influences, int joints) {
  Character c = bending_tube(3, 1, joints);
  for (Influences& i : c.surface.influences) i = influences;
  const std::array levels = {as_level(c.surface, 4, 0)};
  const auto bytes = pack(c, levels);
  const auto weights = decoded<std::uint8_t>(opened(bytes), 0, SLOD_WEIGHT);
  return {weights[0], weights[1], weights[2], weights[3]};
}

void check_same(const std::vector<std::byte>& a, const std::vector<std::byte>& b, slod_kind kind) {
  CHECK(decoded<std::uint8_t>(opened(a), 0, kind) == decoded<std::uint8_t>(opened(b), 0, kind));
}

}  // namespace

TEST_SUITE("pack") {
  TEST_CASE("a level comes back within half a step of each grid") {
    const auto levels = tube_levels();
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    REQUIRE(file.level_count == levels.size());
    for (std::uint32_t level = 0; level < file.level_count; ++level) {
      const Surface& surface = levels[level].surface;
      const AttributeLayout& layout = surface.layout;
      const std::vector<int> source = sources(file, level, surface);
      REQUIRE(source.size() == surface.wedges.size());
      const auto x = unpacked(file, level, SLOD_POSITION), n = unpacked(file, level, SLOD_NORMAL);
      const auto t = unpacked(file, level, SLOD_TANGENT), rgba = unpacked(file, level, SLOD_COLOUR);
      const slod_chunk grid = chunk_of(file, level, SLOD_POSITION);
      for (size_t i = 0; i < source.size(); ++i) {
        const auto row = surface.attributes.row(source[i]);
        const Vec3 offset = point(x, i) - surface.position[size_t(surface.wedges[size_t(source[i])].vertex)];
        for (int c = 0; c < 3; ++c) CHECK(std::abs(offset[c]) <= 0.501 * double(grid.step[c]) + 1e-6);
        CHECK((point(n, i) - Vec3(row.head<3>().transpose())).norm() < 1e-4);
        const Vec3 tangent(t[4 * i], t[4 * i + 1], t[4 * i + 2]);
        CHECK((tangent - Vec3(row.segment<3>(layout.tangent_at()).transpose())).norm() < 0.02);
        CHECK(t[4 * i + 3] == row[layout.tangent_at() + 3]);
        for (int c = 0; c < 4; ++c) {
          CHECK(std::abs(double(rgba[4 * i + size_t(c)]) - row[layout.colour_at(0) + c]) < 0.501 / 255);
        }
        for (int set = 0; set < 2; ++set) {
          const auto uv = unpacked(file, level, SLOD_UV, std::uint32_t(set));
          for (int c = 0; c < 2; ++c) {
            CHECK(std::abs(double(uv[2 * i + size_t(c)]) - row[layout.uv_at(set) + c]) <
                  3 * 0.501 / 65535 + 1e-6);
          }
        }
      }
    }
  }

  TEST_CASE("the triangles of every level come back each once and the same way round") {
    const auto levels = tube_levels();
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    for (std::uint32_t level = 0; level < file.level_count; ++level) {
      const std::vector<int> source = sources(file, level, levels[level].surface);
      const auto indices = decoded_indices(file, level);
      std::vector<std::array<int, 3>> back;
      for (size_t i = 0; i < indices.size(); i += 3) {
        back.push_back(turned({source[indices[i]], source[indices[i + 1]], source[indices[i + 2]]}));
      }
      std::ranges::sort(back);
      CHECK(back == triangles(levels[level].surface));
    }
  }

  TEST_CASE("the posed level equals the pipeline's to within the steps of positions and weights") {
    const Character character = decorated_tube(12, 10);
    const auto levels = tube_levels();
    const auto bytes = pack(character, levels);
    const slod_file file = opened(bytes);
    for (const Clip& clip : character.clips) {
      const Palette palette = sample(character.skeleton, clip, 0.8);
      std::vector<float> rows;
      for (const Affine& m : palette) {
        for (int i = 0; i < 12; ++i) rows.push_back(float(m(i / 4, i % 4)));
      }
      for (std::uint32_t level = 0; level < file.level_count; ++level) {
        const Surface& surface = levels[level].surface;
        const std::vector<int> source = sources(file, level, surface);
        const std::vector<Vec3> expected = pose_vertices(surface, palette);
        const auto joints = decoded<std::uint8_t>(file, level, SLOD_JOINT_INDEX);
        const auto weights = decoded<std::uint8_t>(file, level, SLOD_WEIGHT);
        auto x = unpacked(file, level, SLOD_POSITION);
        slod_skin(&file, level, joints.data(), weights.data(), rows.data(), x.data(), nullptr);

        const slod_chunk grid = chunk_of(file, level, SLOD_POSITION);
        const double half_step = Vec3(grid.step[0], grid.step[1], grid.step[2]).norm() / 2;
        double moved = 0;
        for (size_t i = 0; i < source.size(); ++i) {
          const size_t v = size_t(surface.wedges[size_t(source[i])].vertex);
          // A weight that is wrong by d moves the point by d times the way from one joint's place to the
          // other's.
          double spread = 0;
          for (const Influence& a : surface.influences[v]) {
            const Vec3 off = transform(palette[size_t(a.joint)], surface.position[v]) - expected[v];
            spread += off.norm() / 255;
          }
          CHECK((point(x, i) - expected[v]).norm() <= half_step + spread + 2e-6);
          moved = std::max(moved, (expected[v] - surface.position[v]).norm());
        }
        CHECK(moved > 0.5);
      }
    }
  }

  TEST_CASE("morphs come back within half a step") {
    const Character character = decorated_tube(12, 10);
    const auto levels = tube_levels();
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    const float on[2] = {1, 1};
    for (std::uint32_t level = 0; level < file.level_count; ++level) {
      const Surface& surface = levels[level].surface;
      const std::vector<int> source = sources(file, level, surface);
      const auto ranges = decoded<std::uint32_t>(file, level, SLOD_MORPH_RANGE);
      const auto offsets = decoded<slod_morph_offset>(file, level, SLOD_MORPH_OFFSET);
      CHECK(ranges[1] == offsets.size());
      CHECK(ranges[2] == offsets.size());
      const slod_chunk chunk = chunk_of(file, level, SLOD_MORPH_OFFSET);
      std::vector<float> x(3 * source.size()), n(3 * source.size());
      slod_add_morphs(&file, &chunk, ranges.data(), offsets.data(), on, x.data(), n.data());
      int moved = 0;
      for (size_t i = 0; i < source.size(); ++i) {
        const size_t w = size_t(source[i]);
        const auto& morphs = surface.morphs[size_t(surface.wedges[w].vertex)];
        const auto& normals = surface.normal_morphs[w];
        const Vec3 delta = morphs.empty() ? Vec3::Zero() : morphs[0].delta;
        const Vec3 normal = normals.empty() ? Vec3::Zero() : normals[0].delta;
        CHECK((point(x, i) - delta).cwiseAbs().maxCoeff() <= 0.501 * double(chunk.step[0]));
        CHECK((point(n, i) - normal).cwiseAbs().maxCoeff() <= 0.501 * double(chunk.step[3]));
        moved += delta.norm() > 0.1;
      }
      CHECK(moved > 0);
    }
  }

  TEST_CASE("weights are rounded by largest remainder to a sum of 255") {
    using Bytes4 = std::array<std::uint8_t, 4>;
    CHECK(packed_weights({{0, 1.0 / 3}, {1, 1.0 / 3}, {2, 1.0 / 3}}, 3) == Bytes4{85, 85, 85, 0});
    CHECK(packed_weights({{0, 0.5}, {1, 0.5}}, 2) == Bytes4{128, 127, 0, 0});
    CHECK(packed_weights({{0, 0.999}, {1, 0.001}}, 2) == Bytes4{255, 0, 0, 0});
    CHECK(packed_weights({{0, 0.1}, {1, 0.9}}, 2) == Bytes4{229, 26, 0, 0});  // 25.5 and 229.5: a tie
    CHECK(packed_weights({{0, 0.25}, {1, 0.25}, {2, 0.25}, {3, 0.25}}, 4) == Bytes4{64, 64, 64, 63});
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    for (std::uint32_t level = 0; level < file.level_count; ++level) {
      const auto weights = decoded<std::uint8_t>(file, level, SLOD_WEIGHT);
      for (size_t i = 0; i < weights.size(); i += 4) {
        CHECK(weights[i] + weights[i + 1] + weights[i + 2] + weights[i + 3] == 255);
      }
    }
  }

  TEST_CASE("wedges of one vertex are bit-equal in position and influences even across sections") {
    // Two parts, so that every vertex of the border has wedges in both, with their own joint tables.
    Character c = decorated_tube(12, 10);
    c.parts.push_back(c.parts[0]);
    Surface& s = c.surface;
    const int wedges = int(s.wedges.size());
    for (int f = 0; f < s.face_count() / 2; ++f) {
      for (int i = s.face_begin[size_t(f)]; i < s.face_begin[size_t(f) + 1]; ++i) {
        s.corners[size_t(i)] += wedges;
      }
    }
    for (int w = 0; w < wedges; ++w) s.wedges.push_back({s.wedges[size_t(w)].vertex, 1});
    const Rows once = s.attributes;
    s.attributes.resize(2 * wedges, once.cols());
    s.attributes << once, once;
    s.normal_morphs.insert(s.normal_morphs.end(), s.normal_morphs.begin(), s.normal_morphs.begin() + wedges);
    const std::array levels = {as_level(s, 4, 0)};
    const auto bytes = pack(c, levels);
    const slod_file file = opened(bytes);
    REQUIRE(slod_get_level(&file, 0).section_count == 2);

    const auto source = sources(file, 0, s);
    const auto positions = decoded<std::array<std::uint16_t, 4>>(file, 0, SLOD_POSITION);
    const auto joints = decoded<std::uint8_t>(file, 0, SLOD_JOINT_INDEX);
    const auto weights = decoded<std::uint8_t>(file, 0, SLOD_WEIGHT);
    using Bound = std::pair<std::array<std::uint16_t, 4>, std::vector<std::pair<std::uint32_t, int>>>;
    std::map<int, Bound> first;  // of each vertex
    int shared = 0;
    for (std::uint32_t i = 0; i < 2; ++i) {
      const slod_section section = slod_get_section(&file, i);
      for (size_t v = section.first_vertex; v < section.first_vertex + section.vertex_count; ++v) {
        Bound bound{positions[v], {}};
        for (size_t k = 4 * v; k < 4 * v + 4 && weights[k] > 0; ++k) {
          bound.second.push_back(
              {slod_get_section_joint(&file, section.first_joint + joints[k]).joint, weights[k]});
        }
        const auto [found, fresh] = first.try_emplace(s.wedges[size_t(source[v])].vertex, bound);
        CHECK(found->second == bound);
        shared += !fresh;
      }
    }
    CHECK(shared > 12);
  }

  TEST_CASE("raw and compressed files hold the same streams") {
    const auto small = packed_tube(), raw = packed_tube({.compress = false});
    CHECK(small.size() < raw.size());
    for (const slod_kind kind : {SLOD_POSITION, SLOD_NORMAL, SLOD_TANGENT, SLOD_UV, SLOD_COLOUR,
                                 SLOD_JOINT_INDEX, SLOD_WEIGHT, SLOD_MORPH_RANGE, SLOD_MORPH_OFFSET}) {
      CAPTURE(kind);
      check_same(small, raw, kind);
    }
  }

  TEST_CASE("packing twice gives the same bytes") { CHECK(packed_tube() == packed_tube()); }

  TEST_CASE("the coarsest level stands first in the file") {
    const auto bytes = packed_tube();
    const slod_file file = opened(bytes);
    std::uint32_t last = 2;
    for (std::uint32_t c = SLOD_SHARED_KINDS; c < file.chunk_count; ++c) {
      const slod_chunk chunk = slod_get_chunk(&file, c);
      CHECK(chunk.level <= last);
      CHECK(chunk.offset % 16 == 0);
      last = chunk.level;
    }
    CHECK(last == 0);
    CHECK(slod_get_level(&file, 2).triangle_count < slod_get_level(&file, 0).triangle_count);
    CHECK(slod_get_level(&file, 1).examples.max == 0.01f);
    CHECK(slod_get_level(&file, 2).max_influences == 2);
  }

  TEST_CASE("a part that follows more than 256 joints is split and poses alike") {
    constexpr int kJoints = 600;
    Character c = bending_tube(4, 700, kJoints);
    const std::array levels = {as_level(c.surface, 4, 0)};
    const auto bytes = pack(c, levels);
    const slod_file file = opened(bytes);
    const slod_level level = slod_get_level(&file, 0);
    CHECK(level.section_count == 3);
    CHECK(level.triangle_count == std::uint32_t(c.surface.face_count()));
    const auto x = unpacked(file, 0, SLOD_POSITION);
    auto joints = decoded<std::uint8_t>(file, 0, SLOD_JOINT_INDEX);
    const auto weights = decoded<std::uint8_t>(file, 0, SLOD_WEIGHT);
    // Joint j lifts by j: so each vertex must rise by the joint that its height asks for.
    std::vector<float> palette;
    for (int j = 0; j < kJoints; ++j) {
      palette.insert(palette.end(), {1, 0, 0, 0, 0, 1, 0, float(j), 0, 0, 1, 0});
    }
    auto posed = x;
    slod_skin(&file, 0, joints.data(), weights.data(), palette.data(), posed.data(), nullptr);
    for (size_t v = 0; v < x.size() / 3; ++v) {
      const double height = std::clamp(point(x, v).y() - 0.5, 0.0, kJoints - 1.0);
      CHECK(std::abs(point(posed, v).y() - point(x, v).y() - height) < 0.02);
    }
  }

  TEST_CASE("a level of more than 65535 render vertices has wide indices") {
    Character c = bending_tube(3, 1, 2);
    c.surface = tube(64, 1100, 2);
    const std::array levels = {as_level(c.surface, 4, 0)};
    const auto bytes = pack(c, levels);
    const slod_file file = opened(bytes);
    CHECK(slod_get_level(&file, 0).vertex_count == 64 * 1101);
    CHECK(chunk_of(file, 0, SLOD_INDEX).stride == 4);
    const auto indices = decoded_indices(file, 0);
    CHECK(*std::ranges::max_element(indices) == 64 * 1101 - 1);
  }

  TEST_CASE("eight influences take eight slots") {
    Character c = bending_tube(4, 2, 8);
    for (Influences& influences : c.surface.influences) {
      influences.clear();
      for (int j = 0; j < 8; ++j) influences.push_back({j, (j + 1) / 36.0});
    }
    const std::array levels = {as_level(c.surface, 8, 0)};
    const auto bytes = pack(c, levels);
    const slod_file file = opened(bytes);
    CHECK(slod_get_level(&file, 0).influence_slots == 8);
    const auto joints = decoded<std::uint8_t>(file, 0, SLOD_JOINT_INDEX);
    const auto weights = decoded<std::uint8_t>(file, 0, SLOD_WEIGHT);
    for (int k = 0; k < 8; ++k) {
      CHECK(joints[size_t(k)] == 7 - k);
      CHECK(weights[size_t(k)] == doctest::Approx(255 * (8 - k) / 36.0).epsilon(0.1));
    }
  }

  TEST_CASE("a flat or single-valued coordinate keeps its value") {
    Character c = bending_tube(3, 1, 2);
    Surface& s = c.surface;
    for (Vec3& x : s.position) x.z() = 0.1;
    const std::array levels = {as_level(s, 4, 0)};
    const auto bytes = pack(c, levels);
    const auto x = unpacked(opened(bytes), 0, SLOD_POSITION);
    for (size_t v = 0; v < x.size() / 3; ++v) CHECK(x[3 * v + 2] == 0.1f);
  }

  TEST_CASE("nodes are written parents first whatever their order was") {
    Character c = decorated_tube(6, 4);
    auto& nodes = c.skeleton.nodes;
    std::swap(nodes[0], nodes[4]);
    const auto moved = [](int n) { return n == 0 ? 4 : n == 4 ? 0 : n; };
    for (Node& n : nodes) n.parent = moved(n.parent);
    for (Joint& j : c.skeleton.joints) j.node = moved(j.node);
    Affine shear = identity();
    shear(0, 1) = 0.5;
    nodes[2].matrix = shear;
    const std::array levels = {as_level(c.surface, 4, 0)};
    const auto bytes = pack(c, levels);
    const slod_file file = opened(bytes);
    std::map<std::string, std::string> parent;
    for (std::uint32_t i = 0; i < slod_count(&file, SLOD_NODES); ++i) {
      const slod_node n = slod_get_node(&file, i);
      parent[slod_name(&file, n.name)] =
          n.parent < 0 ? "" : slod_name(&file, slod_get_node(&file, n.parent).name);
    }
    CHECK(parent["joint0"].empty());
    CHECK(parent["joint4"] == "joint3");
    CHECK(parent["joint1"] == "joint0");
    for (std::uint32_t j = 0; j < 5; ++j) {
      const slod_node n = slod_get_node(&file, slod_get_joint(&file, j).node);
      CHECK(slod_name(&file, n.name) == "joint" + std::to_string(j));
    }
    std::vector<float> locals(12 * size_t(slod_count(&file, SLOD_NODES)));
    slod_rest_locals(&file, locals.data());
    CHECK(std::ranges::count(locals, 0.5f) == 1);
  }

  TEST_CASE("levels that break the chain's promises are our fault") {
    const Character c = bending_tube(4, 5, 3);
    const auto refuses = [&](const Level& level, const std::string& fact) {
      try {
        pack(c, std::span(&level, 1));
        FAIL("packed");
      } catch (const Error& e) {
        CHECK(e.fault == Fault::Ours);
        CHECK(std::string(e.what()).find("level 0: ") != std::string::npos);
        CHECK(std::string(e.what()).find(fact) != std::string::npos);
      }
    };
    refuses(as_level(Surface{}, 4, 0), "no triangles");
    refuses(as_level(c.surface, 1, 0), "has 2 influences");
    refuses(as_level(c.surface, 9, 0), "cap of 9");
    Level bare = as_level(c.surface, 4, 0);
    bare.surface.influences[5].clear();
    refuses(bare, "vertex 5 has 0 influences");
    Level quads = as_level(c.surface, 4, 0);
    quads.surface.add_face(std::array{0, 1, 2, 3});
    refuses(quads, "no triangle");
    CHECK_THROWS_AS(pack(c, {}), Error);
  }
}

}  // namespace skinlod
