// SPDX-License-Identifier: MIT
#include "formats/slod.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

#include "pipeline/error.h"
#include "tests/packed_tube.h"

namespace skinlod {
namespace {

std::string slod_refusal(const std::vector<std::byte>& bytes) {
  try {
    read_slod(bytes, "hero.slod");
  } catch (const Error& e) {
    CHECK(e.fault == Fault::Input);
    return e.what();
  }
  return "none";
}

}  // namespace

TEST_SUITE("slod") {
  TEST_CASE("the character comes back with its names and links") {
    const Character source = decorated_tube(12, 10);
    const SlodFile file = read_slod(packed_tube(), "tube.slod");
    const Character& c = file.character;
    CHECK(c.name == "bending_tube");
    REQUIRE(c.skeleton.nodes.size() == source.skeleton.nodes.size());
    for (size_t n = 0; n < c.skeleton.nodes.size(); ++n) {
      CHECK(c.skeleton.nodes[n].name == source.skeleton.nodes[n].name);
      CHECK(c.skeleton.nodes[n].parent == source.skeleton.nodes[n].parent);
      CHECK(c.skeleton.nodes[n].rest.translation == source.skeleton.nodes[n].rest.translation);
      CHECK_FALSE(c.skeleton.nodes[n].matrix.has_value());
    }
    REQUIRE(c.skeleton.joints.size() == 5);
    for (size_t j = 0; j < 5; ++j) {
      CHECK(c.skeleton.joints[j].node == int(j));
      CHECK(c.skeleton.joints[j].inverse_bind == source.skeleton.joints[j].inverse_bind);
    }
    REQUIRE(c.materials.size() == 1);
    CHECK(c.materials[0].name == "skin");
    REQUIRE(c.parts.size() == 1);
    CHECK(c.parts[0].name == "body");
    CHECK(c.parts[0].node == 5);
    CHECK(c.parts[0].material == 0);
    CHECK(c.parts[0].has == source.parts[0].has);
    REQUIRE(c.morphs.size() == 2);
    CHECK(c.morphs[0].name == "bulge");
    CHECK(c.morphs[0].weight == 0.25);
    CHECK(c.morphs[1].name == "still");
  }

  TEST_CASE("levels come back welded as they went in") {
    const auto levels = tube_levels();
    const auto bytes = packed_tube();
    const SlodFile file = read_slod(bytes, "tube.slod");
    REQUIRE(file.levels.size() == levels.size());
    size_t stored = 0;
    for (size_t i = 0; i < levels.size(); ++i) {
      const Surface &in = levels[i].surface, &out = file.levels[i].surface;
      CHECK(out.layout == in.layout);
      CHECK(out.face_count() == in.face_count());
      CHECK(out.wedges.size() == in.wedges.size());
      CHECK(out.attributes.rows() == in.attributes.rows());
      REQUIRE(out.position.size() == in.position.size());
      for (size_t v = 0; v < in.position.size(); ++v) {
        const auto nearest = std::ranges::min_element(
            out.position, {}, [&](const Vec3& x) { return (x - in.position[v]).norm(); });
        CHECK((*nearest - in.position[v]).norm() < 1e-4);
        const size_t o = size_t(nearest - out.position.begin());
        REQUIRE(out.influences[o].size() == in.influences[v].size());
        for (size_t k = 0; k < in.influences[v].size(); ++k) {
          CHECK(out.influences[o][k].joint == in.influences[v][k].joint);
          CHECK(std::abs(out.influences[o][k].weight - in.influences[v][k].weight) < 1.0 / 255);
        }
        REQUIRE(out.morphs[o].size() == in.morphs[v].size());
        if (!in.morphs[v].empty()) {
          CHECK(out.morphs[o][0].morph == 0);
          CHECK((out.morphs[o][0].delta - in.morphs[v][0].delta).norm() < 1e-4);
        }
      }
      CHECK(file.levels[i].max_influences == levels[i].max_influences);
      CHECK(file.levels[i].error_rms == doctest::Approx(levels[i].examples.rms));
      CHECK(file.levels[i].error_max == doctest::Approx(levels[i].examples.max));
      CHECK(file.levels[i].unseen_clip.max == doctest::Approx(levels[i].unseen_clip.max));
      CHECK(file.levels[i].unseen_motion.rms == doctest::Approx(levels[i].unseen_motion.rms));
      stored += file.levels[i].bytes;
    }
    slod_header header;
    std::memcpy(&header, bytes.data(), sizeof header);
    CHECK(stored + header.head_bytes == bytes.size());
  }

  TEST_CASE("what was read packs into the same levels again") {
    const auto bytes = packed_tube();
    const SlodFile once = read_slod(bytes, "once");
    std::vector<Level> levels;
    for (const SlodLevel& l : once.levels) {
      levels.push_back(as_level(l.surface, l.max_influences, l.error_max));
    }
    const SlodFile twice = read_slod(pack(once.character, levels), "twice");
    for (size_t i = 0; i < levels.size(); ++i) {
      const Surface &a = once.levels[i].surface, &b = twice.levels[i].surface;
      REQUIRE(a.position.size() == b.position.size());
      const auto by_place = [](const Vec3& p, const Vec3& q) {
        return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
      };
      auto x = a.position, y = b.position;
      std::ranges::sort(x, by_place), std::ranges::sort(y, by_place);
      double difference = 0;
      for (size_t v = 0; v < x.size(); ++v) difference = std::max(difference, (x[v] - y[v]).norm());
      CHECK(difference < 1e-6);
    }
  }

  TEST_CASE("a file that cannot be read is refused with its name and the fact and a remedy") {
    const auto good = packed_tube();
    CHECK(slod_refusal(good) == "none");
    CHECK(slod_refusal({}) != "none");
    auto bytes = good;
    bytes[0] = std::byte('x');
    CHECK(slod_refusal(bytes) ==
          "hero.slod: this is not a .slod file: give a file that `skinlod cook` wrote");
    bytes = good;
    bytes[8] = std::byte(9);
    CHECK(slod_refusal(bytes).find("version") != std::string::npos);
    bytes = good;
    bytes.resize(bytes.size() - 1);
    CHECK(slod_refusal(bytes) == "hero.slod: the file ends too early: copy it again, or cook it again");
    bytes = good;
    bytes.back() ^= std::byte(1);
    CHECK(slod_refusal(bytes).find("damaged") != std::string::npos);
  }
}

}  // namespace skinlod
