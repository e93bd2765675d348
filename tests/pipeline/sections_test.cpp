// SPDX-License-Identifier: MIT
#include "pipeline/sections.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/packed_tube.h"

namespace skinlod {
namespace {

// A tube whose vertices have 1, 2, 4 and 8 influences, a quarter of its length each.
Character tapering_tube(int around, int rings) {
  Character c = bending_tube(3, 1, 8);
  c.surface = tube(around, rings, 4);
  for (size_t v = 0; v < c.surface.position.size(); ++v) {
    Influences& influences = c.surface.influences[v];
    influences.clear();
    const int count = 1 << std::clamp(int(std::floor(c.surface.position[v].y())), 0, 3);
    for (int j = 0; j < count; ++j) influences.push_back({j, 1.0 / count});
  }
  return c;
}

VertexInfluences rounded(const Surface& surface) {
  VertexInfluences all;
  for (const Influences& i : surface.influences) all.push_back(round_weights(i));
  return all;
}

std::vector<std::array<int, 3>> faces_in_order(const Surface& surface) {
  std::vector<std::array<int, 3>> all;
  for (int f = 0; f < surface.face_count(); ++f) {
    all.push_back({surface.face(f)[0], surface.face(f)[1], surface.face(f)[2]});
  }
  return all;
}

std::vector<std::array<int, 3>> faces_in_order(std::span<const Section> sections) {
  std::vector<std::array<int, 3>> all;
  for (const Section& s : sections) {
    for (size_t i = 0; i < s.indices.size(); i += 3) {
      all.push_back({s.wedges[s.indices[i]], s.wedges[s.indices[i + 1]], s.wedges[s.indices[i + 2]]});
    }
  }
  return all;
}

std::vector<std::array<int, 3>> in_order(std::vector<std::array<int, 3>> all) {
  for (auto& t : all) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::ranges::sort(all);
  return all;
}

// What the rule weighs: matrices blended by shaders for 1, 2, 4 and 8 influences, and draw calls.
std::int64_t cost(std::span<const Section> sections) {
  std::int64_t sum = 0;
  for (const Section& s : sections) {
    int shader = 1;
    while (shader < s.max_influences) shader *= 2;
    sum += std::int64_t(s.wedges.size()) * shader + kBlendsPerDraw;
  }
  return sum;
}

}  // namespace

TEST_SUITE("sections") {
  TEST_CASE("a part's sections stand by ascending influences and hold each triangle once") {
    Surface s = tapering_tube(128, 100).surface;
    for (size_t w = 0; w < s.wedges.size(); ++w) s.wedges[w].part = 0;
    const auto influences = rounded(s);
    const std::vector<Section> sections = split(s, influences);
    REQUIRE(sections.size() == 4);
    for (size_t i = 0; i < sections.size(); ++i) {
      CHECK(sections[i].max_influences == 1 << i);
      size_t most = 0;
      for (const int w : sections[i].wedges) {
        most = std::max(most, influences[size_t(s.wedges[size_t(w)].vertex)].size());
      }
      CHECK(most == size_t(sections[i].max_influences));
    }
    CHECK(in_order(faces_in_order(sections)) == in_order(faces_in_order(s)));
    auto lost = in_order(faces_in_order(sections));
    lost.pop_back();
    CHECK(lost != in_order(faces_in_order(s)));
  }

  TEST_CASE("a section more is made only where it pays") {
    // The same tube coarse and fine. A coarse one has too few vertices for a second draw call to save
    // anything.
    CHECK(split(tapering_tube(12, 20).surface, rounded(tapering_tube(12, 20).surface)).size() == 1);
    size_t most = 0;
    for (const int around : {8, 16, 24, 32, 48, 64, 96, 128}) {
      CAPTURE(around);
      const Surface s = tapering_tube(around, around).surface;
      const auto sections = split(s, rounded(s));
      const std::array whole = {Section{
          .part = 0, .max_influences = 8, .wedges = std::vector<int>(s.wedges.size()), .indices = {}}};
      CHECK(cost(sections) <= cost(whole));
      CHECK((cost(sections) < cost(whole)) == (sections.size() > 1));
      CHECK(sections.size() >= most);
      most = std::max(most, sections.size());
    }
    CHECK(most == 4);
    // Where all need as many, there is nothing to save.
    const Surface alike = tube(96, 96, 0.9);
    CHECK(split(alike, rounded(alike)).size() == 1);
  }

  TEST_CASE("the file says of its sections what they hold, and the loader poses them as one surface") {
    Character c = tapering_tube(128, 100);
    const std::array levels = {as_level(c.surface, 8, 0)};
    const auto bytes = pack(c, levels);
    const slod_file file = opened(bytes);
    REQUIRE(slod_get_level(&file, 0).section_count == 4);
    std::vector<float> palette;  // joint j lifts by j
    for (int j = 0; j < 8; ++j) palette.insert(palette.end(), {1, 0, 0, 0, 0, 1, 0, float(j), 0, 0, 1, 0});
    const auto rest = unpacked(file, 0, SLOD_POSITION);
    auto posed = rest;
    slod_skin(&file, 0, decoded<std::uint8_t>(file, 0, SLOD_JOINT_INDEX).data(),
              decoded<std::uint8_t>(file, 0, SLOD_WEIGHT).data(), palette.data(), posed.data(), nullptr);
    for (std::uint32_t s = 0; s < 4; ++s) {
      const slod_section section = slod_get_section(&file, s);
      CHECK(section.max_influences == 1u << s);
      for (size_t v = section.first_vertex; v < section.first_vertex + section.vertex_count; ++v) {
        // Of n influences that weigh the same the mean lift is (n - 1) / 2; weights are rounded to 255ths.
        const int n = 1 << std::clamp(int(std::floor(point(rest, v).y() + 1e-4)), 0, 3);
        CHECK(std::abs(point(posed, v).y() - point(rest, v).y() - (n - 1) / 2.0) < 0.06);
      }
    }
  }
}

}  // namespace skinlod
