// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <random>

#include "formats/isolate.h"
#include "tests/formats/gltf_sample.h"
#include "tests/formats/scratch.h"
#include "tests/fuzz/corpus.h"
#include "tests/fuzz/readers.h"  // what libFuzzer runs

namespace skinlod {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kGltfMemory = std::uint64_t(128) << 20;

// What becomes of a file that is read and written, in little memory: empty, or what it is refused with.
std::string refusal(const GltfFile& file, const Scratch& folder) {
  const std::string path = folder.file("sample.glb", text(file.glb()));
  try {
    run_isolated(path, {.cpu_seconds = 20, .memory_bytes = kGltfMemory}, [&] {
      Imported imported = import_gltf(path);
      repair(imported.character);
      return write_glb(imported.character, imported.character.surface, imported.document.get());
    });
  } catch (const Error& e) {
    CHECK(e.fault == Fault::Input);
    return e.what();
  }
  return {};
}

void check_refused(const GltfFile& file, const std::string& fact) {
  const std::string message = refusal(file, Scratch());
  CAPTURE(fact);
  CAPTURE(message);
  CHECK(message.find(fact) != std::string::npos);
}

void add_animation(Json& json, int input, int output, const char* path) {
  const Json channel = {{"sampler", 0}, {"target", {{"node", 1}, {"path", path}}}};
  const Json sampler = {{"input", input}, {"output", output}};
  json["animations"].push_back({{"channels", Json::array({channel})}, {"samplers", Json::array({sampler})}});
}

}  // namespace

TEST_SUITE("gltf_hostile") {
  TEST_CASE("the fuzzer's stored inputs are read or refused") {
    int read = 0, refused = 0;
    for (const auto& [name, bytes] : fuzz::corpus("gltf_reader")) {
      const auto& input = name;  // clang 14 captures no structured binding
      CAPTURE(input);
      bool is_read = false;
      CHECK_NOTHROW(is_read = fuzz::read_as_gltf(bytes));
      ++(is_read ? read : refused);
    }
    CHECK(read > 0);
    CHECK(refused > 0);
  }

  TEST_CASE("every truncated file is refused") {
    const std::vector<unsigned char> whole = sample_file().glb();
    REQUIRE(fuzz::read_as_gltf(whole));
    for (size_t size = 0; size < whole.size(); ++size) {
      CAPTURE(size);
      std::vector<unsigned char> prefix(whole.begin(), whole.begin() + std::ptrdiff_t(size));
      CHECK_FALSE(fuzz::read_as_gltf(prefix));
      if (size < 12) continue;
      const auto length = std::uint32_t(size);  // a header that agrees with the file
      std::memcpy(&prefix[8], &length, sizeof length);
      CHECK_FALSE(fuzz::read_as_gltf(prefix));
    }
  }

  TEST_CASE("random bit flips are read or refused") {
    const std::vector<unsigned char> whole = sample_file({.index_type = 5123}).glb();
    int read = 0, refused = 0;
    for (std::uint32_t seed = 0; seed < 5000; ++seed) {
      CAPTURE(seed);
      std::mt19937 random(seed);
      std::vector<unsigned char> flipped = whole;
      const std::uint32_t flips = 1 + random() % 4;
      for (std::uint32_t i = 0; i < flips; ++i)
        flipped[random() % flipped.size()] ^= (unsigned char)(1u << random() % 8);
      bool is_read = false;
      CHECK_NOTHROW(is_read = fuzz::read_as_gltf(flipped));
      ++(is_read ? read : refused);
    }
    CHECK(read > 100);
    CHECK(refused > 100);
  }

  TEST_CASE("a few lines cannot ask for memory that is not in the file") {
    GltfFile file = sample_file();
    CHECK(refusal(file, Scratch()).empty());  // it has room for a good file
    Json& json = file.json;
    Json& primitive = json["meshes"][0]["primitives"][0];
    Json& positions = json["accessors"][primitive["attributes"]["POSITION"].get<size_t>()];
    const auto new_accessor = [&](const char* type, std::int64_t count) {
      json["accessors"].push_back({{"componentType", 5126}, {"type", type}, {"count", count}});
      return int(json["accessors"].size()) - 1;
    };

    SUBCASE("as vertices") {
      positions["count"] = 60'000'000;
      check_refused(file, "mesh 0: primitive 0: brings the vertices to 60000000");
    }
    SUBCASE("as vertices that are zeros") {
      positions.erase("bufferView"), positions["count"] = 1'000'000;
      check_refused(file, "brings the vertices to 1000000");
    }
    SUBCASE("as vertices that are zeros but for one") {
      const int bytes = primitive["indices"].get<int>();
      positions.erase("bufferView"), positions["count"] = std::int64_t(1) << 31;
      positions["sparse"] = {
          {"count", 1},
          {"indices",
           {{"bufferView", json["accessors"][size_t(bytes)]["bufferView"]}, {"componentType", 5121}}},
          {"values", {{"bufferView", 0}}}};
      check_refused(file, "brings the vertices to 2147483648");
    }
    SUBCASE("as faces") {
      json["accessors"][primitive["indices"].get<size_t>()]["count"] = 60'000'000;
      check_refused(file, "brings the corners of faces to 60000000");
    }
    SUBCASE("as zeros of another kind") {
      json["skins"][0]["inverseBindMatrices"] = new_accessor("MAT4", 60'000'000);
      check_refused(file, "stands for 3840000000 bytes and has none");
    }
    SUBCASE("as sets of attributes") {
      for (int set = 0; set < 9; ++set)
        primitive["attributes"]["TEXCOORD_" + std::to_string(set)] = primitive["attributes"]["TEXCOORD_0"];
      check_refused(file, "more than 8 sets of TEXCOORD");
    }
    SUBCASE("as instances") {
      for (int n = 5; n < 5000; ++n) {
        json["nodes"].push_back({{"mesh", 1}});
        json["scenes"][0]["nodes"].push_back(n);
      }
      check_refused(file, "too many meshes");
    }
    SUBCASE("as skins") {
      for (int n = 5; n < 1100; ++n) {
        json["nodes"].push_back({{"mesh", 0}, {"skin", n - 4}});
        json["scenes"][0]["nodes"].push_back(n);
        json["skins"].push_back(json["skins"][0]);
      }
      check_refused(file, "too many skins");
    }
    SUBCASE("as morph targets") {
      for (int t = 0; t < 20000; ++t) primitive["targets"].push_back(Json::object());
      check_refused(file, "too many morph targets");
    }
    SUBCASE("as offsets of morphs that share their bytes") {
      for (int t = 0; t < 16000; ++t) primitive["targets"].push_back(primitive["targets"][0]);
      positions["count"] = 250'000;
      json["accessors"][primitive["targets"][0]["POSITION"].get<size_t>()]["count"] = 250'000;
      check_refused(file, "brings the morph offsets to 500012");
    }
    SUBCASE("as offsets of morphs that are zeros") {
      positions["count"] = 250'000;
      const int zeros = new_accessor("VEC3", 250'000);
      for (int t = 0; t < 16000; ++t) primitive["targets"].push_back({{"POSITION", zeros}});
      check_refused(file, "brings the morph offsets to 268500000");
    }
    SUBCASE("as keys") {
      const int times = new_accessor("SCALAR", 300'000), values = new_accessor("VEC3", 300'000);
      for (int a = 0; a < 100; ++a) add_animation(json, times, values, "translation");
      check_refused(file, "brings the keys and values of all clips to more than");
    }
    SUBCASE("as nodes") {
      for (int n = 5; n < 20000; ++n) json["nodes"].push_back(Json::object());
      check_refused(file, "has 20000 nodes, more than 16384");
    }
    SUBCASE("as objects that weigh more than their text") {
      for (int n = 0; n < 70000; ++n) json["materials"].push_back(Json::object());
      check_refused(file, "materials: has 70001 items, more than 65536");
    }
    SUBCASE("as one name for many parts") {
      json["meshes"][0]["name"] = std::string(1'000'000, 'n');
      json["meshes"][0]["primitives"] = std::vector<Json>(1000, primitive);
      check_refused(file, "meshes[0]: has a name of 1000000 bytes");
    }
    SUBCASE("as one name for a morph of many nodes") {
      json["meshes"][0]["extras"]["targetNames"] = Json::array({std::string(1'000'000, 'n')});
      check_refused(file, "mesh 0: has a name of 1000000 bytes");
    }
    SUBCASE("as zeros that an extension names") {
      for (int a = 0; a < 100; ++a)
        json["extensions"]["X_zeros"].push_back({{"accessor", new_accessor("VEC4", 500'000)}});
      check_refused(file, "name the same bytes many times over");
    }
    SUBCASE("as buffer views that overlap") {
      file.buffer.resize(100'000);
      for (int v = 0; v < 2000; ++v) {
        json["extensions"]["X_views"].push_back({{"bufferView", json["bufferViews"].size()}});
        json["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 90'000}});
      }
      check_refused(file, "name the same bytes many times over");
    }
  }

  TEST_CASE("a file beside it that is named many times is read and written once") {
    const Scratch folder;
    GltfFile file = sample_file();
    const std::string image = "\x89PNG" + std::string(1'000'000, 'x');
    folder.file("image.png", image);
    for (int i = 0; i < 500; ++i) {
      file.json["images"].push_back({{"uri", i % 2 ? "image.png" : "./%69mage.png"}});
      file.json["buffers"].push_back({{"uri", "image.png"}, {"byteLength", 1000}});
    }
    CHECK(refusal(file, folder).empty());
    const Imported imported = import_gltf(folder.file("sample.glb", text(file.glb())));
    CHECK(imported.files_read.size() == 2);
    const Surface& surface = imported.character.surface;
    const size_t written = write_glb(imported.character, surface, imported.document.get()).size();
    CHECK(written > image.size());
    CHECK(written < 2 * image.size());
  }

  TEST_CASE("a chain of nodes is read in no time and a circle is refused") {
    GltfFile file = sample_file();
    Json& nodes = file.json["nodes"];
    const auto first = int(nodes.size());
    for (int n = first; n < 16000; ++n) nodes.push_back({{"children", Json::array({n + 1})}});
    nodes.push_back(Json::object());
    CHECK(refusal(file, Scratch()).empty());
    nodes.back()["children"] = Json::array({first});
    check_refused(file, "hangs in a circle");
  }
}

}  // namespace skinlod
