// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <optional>

#include "formats/gltf.h"
#include "pipeline/error.h"
#include "pipeline/morphs.h"
#include "pipeline/pose.h"
#include "tests/formats/gltf_sample.h"
#include "tests/formats/scratch.h"
#include "tests/shapes.h"

namespace skinlod {
namespace {

using Json = nlohmann::json;

std::span<const unsigned char> chars(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()};
}

Imported import(std::span<const unsigned char> glb) {
  const Scratch folder;
  return import_gltf(folder.file("sample.glb", text(glb)));
}

Json json_of(const std::vector<std::byte>& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  return Json::parse(chars(glb).subspan(20, length));
}

Json written(const Imported& imported, const Surface& surface) {
  return json_of(write_glb(imported.character, surface, imported.document.get()));
}

// The surface without the faces of one part.
Surface without(const Surface& surface, int part) {
  Surface level = surface;
  level.corners.clear();
  level.face_begin = {0};
  for (int f = 0; f < surface.face_count(); ++f) {
    if (surface.part(f) != part) level.add_face(surface.face(f));
  }
  return level;
}

// As `repair` leaves them: real files hold weights that do not sum to 1.
void normalise(Surface& surface) {
  for (Influences& influences : surface.influences) {
    double sum = 0;
    for (const Influence& influence : influences) sum += influence.weight;
    for (Influence& influence : influences) influence.weight /= sum;
  }
}

// The largest distance between two vertices of the same index over some times of all clips, by the diagonal.
double difference(const Character& a, const Character& b) {
  REQUIRE(a.surface.position.size() == b.surface.position.size());
  REQUIRE(a.clips.size() == b.clips.size());
  double worst = 0;
  for (size_t k = 0; k < std::min<size_t>(a.clips.size(), 5); ++k) {
    for (const double part : {0.0, 0.31, 0.77, 1.0}) {
      const double time = part * a.clips[k].duration();
      const auto x = pose_vertices(a.surface, sample(a.skeleton, a.clips[k], time));
      const auto y = pose_vertices(b.surface, sample(b.skeleton, b.clips[k], time));
      for (size_t v = 0; v < x.size(); ++v) worst = std::max(worst, (x[v] - y[v]).norm());
    }
  }
  return worst / diagonal(a.surface.position);
}

void check_same(const Character& a, const Character& b) {
  CHECK(difference(a, b) < 1e-6);
  CHECK(a.surface.corners == b.surface.corners);
  CHECK((a.surface.attributes - b.surface.attributes).cwiseAbs().maxCoeff() < 1e-6);
  REQUIRE(a.parts.size() == b.parts.size());
  for (size_t p = 0; p < a.parts.size(); ++p) {
    CHECK(a.parts[p].node == b.parts[p].node);
    CHECK(a.parts[p].material == b.parts[p].material);
    CHECK(a.parts[p].has == b.parts[p].has);
  }
  REQUIRE(a.morphs.size() == b.morphs.size());
  for (size_t m = 0; m < a.morphs.size(); ++m) CHECK(a.morphs[m].name == b.morphs[m].name);
  REQUIRE(a.surface.morphs.size() == b.surface.morphs.size());
  for (size_t v = 0; v < a.surface.morphs.size(); ++v) {
    REQUIRE(a.surface.morphs[v].size() == b.surface.morphs[v].size());
    for (size_t i = 0; i < a.surface.morphs[v].size(); ++i) {
      CHECK((a.surface.morphs[v][i].delta - b.surface.morphs[v][i].delta).norm() < 1e-6);
    }
  }
}

}  // namespace

TEST_SUITE("gltf_write") {
  TEST_CASE("what is written is read back the same with and without its document") {
    const Imported imported = import(sample_file().glb());
    const Character& c = imported.character;
    for (const GltfDocument* document :
         {imported.document.get(), static_cast<const GltfDocument*>(nullptr)}) {
      const std::vector<std::byte> glb = write_glb(c, c.surface, document);
      CHECK(glb == write_glb(c, c.surface, document));
      check_same(c, import(chars(glb)).character);
    }
  }

  TEST_CASE("a character from elsewhere comes back with its clips and materials") {
    Character c = bending_tube(8, 12, 3);
    c.materials[0].texture = "skin colour.png";
    const std::vector<std::byte> glb = write_glb(c, c.surface);
    const Imported back = import(chars(glb));
    CHECK(triangle_count(back.character.surface) == triangle_count(c.surface));
    CHECK(back.character.surface.layout == c.surface.layout);
    CHECK(back.character.materials[0].name == "skin");
    CHECK(back.character.materials[0].texture == "skin%20colour.png");
    REQUIRE(back.character.clips.size() == 2);
    CHECK(back.character.clips[0].name == "bend");
    const auto& front = c.surface;
    const Palette pose = sample(c.skeleton, c.clips[0], 0.7);
    const Palette same = sample(back.character.skeleton, back.character.clips[0], 0.7);
    const auto x = pose_vertices(front, pose), y = pose_vertices(back.character.surface, same);
    for (size_t i = 0; i < front.wedges.size(); ++i)
      CHECK((x[size_t(front.wedges[i].vertex)] - y[i]).norm() < 1e-5);
  }

  TEST_CASE("what is no geometry survives") {
    GltfFile file = sample_file();
    Json& j = file.json;
    j["extensionsUsed"] = {"VENDOR_thing", "KHR_lights_punctual", "KHR_materials_variants",
                           "KHR_mesh_quantization"};
    j["extensionsRequired"] = {"KHR_mesh_quantization"};
    j["extensions"] = {
        {"VENDOR_thing", {{"deep", {{"bufferView", 0}, {"accessor", 1}, {"big", 9007199254740993}}}}},
        {"KHR_lights_punctual", {{"lights", {{{"type", "point"}}}}}}};
    j["extras"] = {{"of", "file"}};
    j["asset"]["copyright"] = "somebody";
    j["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}};
    j["nodes"][1]["camera"] = 0;
    j["nodes"][2]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    j["nodes"][3]["extras"] = "of node";
    j["meshes"][0]["extras"]["more"] = "of mesh";
    j["meshes"][0]["primitives"][0]["extras"] = "of primitive";
    j["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] = Json::array();
    j["skins"][0]["extras"] = "of skin";
    j["animations"][0]["extras"] = "of animation";
    j["animations"][0]["channels"][0]["extras"] = "of channel";
    j["materials"][0]["extensions"]["KHR_materials_unlit"] = Json::object();
    const Imported imported = import(file.glb());
    const Json out = written(imported, imported.character.surface);

    CHECK(out["asset"]["generator"] == "skinlod");
    CHECK(out["asset"]["copyright"] == "somebody");
    CHECK(out["extensionsUsed"] == Json({"VENDOR_thing", "KHR_lights_punctual", "KHR_materials_variants"}));
    CHECK(!out.contains("extensionsRequired"));
    CHECK(out["extensions"]["KHR_lights_punctual"] == j["extensions"]["KHR_lights_punctual"]);
    CHECK(out["extensions"]["VENDOR_thing"]["deep"]["big"] == 9007199254740993);
    const Json& moved = out["accessors"][out["extensions"]["VENDOR_thing"]["deep"]["accessor"].get<size_t>()];
    CHECK(moved["count"] == 6);
    const Json& view =
        out["bufferViews"][out["extensions"]["VENDOR_thing"]["deep"]["bufferView"].get<size_t>()];
    CHECK(view["byteLength"] == j["bufferViews"][0]["byteLength"]);
    CHECK(out["extras"] == j["extras"]);
    CHECK(out["cameras"] == j["cameras"]);
    CHECK(out["nodes"][1]["camera"] == 0);
    CHECK(out["nodes"][2]["extensions"] == j["nodes"][2]["extensions"]);
    CHECK(out["nodes"][3]["extras"] == "of node");
    CHECK(out["meshes"][0]["extras"] == j["meshes"][0]["extras"]);
    CHECK(out["meshes"][0]["primitives"][0]["extras"] == "of primitive");
    CHECK(out["meshes"][0]["primitives"][0]["extensions"] == j["meshes"][0]["primitives"][0]["extensions"]);
    CHECK(out["skins"][0]["extras"] == "of skin");
    CHECK(out["animations"][0]["extras"] == "of animation");
    CHECK(out["animations"][0]["channels"][0]["extras"] == "of channel");
    CHECK(out["materials"] == j["materials"]);
  }

  TEST_CASE("no byte of the old geometry is left") {
    const Imported imported = import(sample_file().glb());
    const std::vector<std::byte> glb =
        write_glb(imported.character, imported.character.surface, imported.document.get());
    const Json out = json_of(glb);
    size_t used = 0;
    for (const Json& accessor : out["accessors"]) {
      if (!accessor.contains("bufferView")) continue;
      const std::string type = accessor["type"];
      const size_t components = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : size_t(type.back() - '0');
      const size_t size = accessor["componentType"] == 5126 ? 4 : accessor["componentType"] == 5123 ? 2 : 1;
      used += (accessor["count"].get<size_t>() * components * size + 3) / 4 * 4;
    }
    CHECK(out["buffers"].size() == 1);
    CHECK(out["buffers"][0]["byteLength"] == used);
  }

  TEST_CASE("a rigid part stays rigid and a skin holds the joints of the skins alone") {
    const Imported imported = import(sample_file().glb());
    const Json out = written(imported, imported.character.surface);
    CHECK(!out["nodes"][4].contains("skin"));
    CHECK(!out["meshes"][1]["primitives"][0]["attributes"].contains("JOINTS_0"));
    CHECK(out["skins"].size() == 1);
    CHECK(out["skins"][0]["joints"] == Json({1, 2}));
  }

  TEST_CASE("a prop that follows two joints is written skinned") {
    Imported imported = import(sample_file().glb());
    Character& c = imported.character;
    for (size_t v = 6; v < 9; ++v) c.surface.influences[v] = {{0, 0.5}, {2, 0.5}};
    const std::vector<std::byte> glb = write_glb(c, c.surface, imported.document.get());
    CHECK(json_of(glb)["skins"][0]["joints"] == Json({1, 2, 4}));
    check_same(c, import(chars(glb)).character);
  }

  TEST_CASE("a mesh without faces is left out with the channels that moved its morphs") {
    const Imported imported = import(sample_file().glb());
    const Json out = written(imported, without(imported.character.surface, 0));
    CHECK(!out["nodes"][3].contains("mesh"));
    CHECK(!out["nodes"][3].contains("skin"));
    CHECK(!out.contains("skins"));
    CHECK(out["nodes"][4]["mesh"] == 0);
    CHECK(out["meshes"].size() == 1);
    CHECK(out["animations"][0]["channels"].size() == 2);
    CHECK(out["animations"][0]["samplers"].size() == 2);
    CHECK(written(imported, without(imported.character.surface, 1))["meshes"].size() == 1);
  }

  TEST_CASE("meshes keep their order and a primitive without faces goes alone") {
    GltfFile file = sample_file();
    std::swap(file.json["nodes"][3]["mesh"], file.json["nodes"][4]["mesh"]);
    std::swap(file.json["meshes"][0], file.json["meshes"][1]);
    Json& primitives = file.json["meshes"][1]["primitives"];
    primitives.push_back(primitives[0]);
    primitives[0]["extras"] = "first", primitives[1]["extras"] = "second";
    const Imported imported = import(file.glb());
    REQUIRE(imported.character.parts.size() == 3);
    CHECK(imported.character.parts[1].name == "body[1]");
    const Json out = written(imported, without(imported.character.surface, 0));
    CHECK(out["meshes"][0]["name"] == "prop");
    CHECK(out["meshes"][1]["name"] == "body");
    REQUIRE(out["meshes"][1]["primitives"].size() == 1);
    CHECK(out["meshes"][1]["primitives"][0]["extras"] == "second");
  }

  TEST_CASE(
      "a target that moves few vertices is sparse, one that moves none has no bytes, and both come back") {
    Character c = bending_tube(12, 40, 4);
    const int node = c.parts[0].node;
    c.morphs = {{"all", node}, {"few", node}, {"none", node}};
    c.surface.morphs.assign(c.surface.position.size(), {{0, Vec3(0, 0.25, 0)}});
    c.surface.morphs[7].push_back({1, Vec3(0.5, 0, 0)});
    c.surface.normal_morphs.assign(c.surface.wedges.size(), {});
    c.surface.normal_morphs[9].push_back({1, Vec3(0, 0, 0.5)});
    const auto glb = write_glb(c, c.surface);
    const Json json = json_of(glb);
    const Json& targets = json["meshes"][0]["primitives"][0]["targets"];
    const auto accessor = [&](size_t target, const char* kind) {
      return json["accessors"][targets[target][kind].get<size_t>()];
    };
    CHECK(accessor(0, "POSITION").contains("bufferView"));
    for (const char* kind : {"POSITION", "NORMAL"}) {
      const Json few = accessor(1, kind), none = accessor(2, kind);
      CHECK(!few.contains("bufferView"));
      CHECK(few["sparse"]["count"] >= 1);
      CHECK(few["sparse"]["count"] <= 2);  // the vertex may have two wedges
      for (const char* part : {"indices", "values"}) {
        const Json& view = json["bufferViews"][few["sparse"][part]["bufferView"].get<size_t>()];
        CHECK(!view.contains("target"));
        CHECK(!view.contains("byteStride"));
      }
      CHECK(!none.contains("bufferView"));
      CHECK(!none.contains("sparse"));
    }
    CHECK(accessor(1, "POSITION")["max"] == Json{0.5, 0, 0});
    const Character back = import(chars(glb)).character;
    REQUIRE(back.morphs.size() == 3);
    size_t few = 0;
    for (const MorphOffsets& offsets : back.surface.morphs) {
      REQUIRE(!offsets.empty());
      CHECK(offsets[0].delta == Vec3(0, 0.25, 0));
      if (offsets.size() < 2) continue;
      CHECK(offsets[1].delta == Vec3(0.5, 0, 0));
      ++few;
    }
    CHECK(few == accessor(1, "POSITION")["sparse"]["count"]);
  }

  TEST_CASE("a character whose morphs were taken away leaves nothing of them") {
    Imported imported = import(sample_file().glb());
    const Json before = written(imported, imported.character.surface);
    CHECK(before.dump().find("targets") != std::string::npos);
    remove_morphs(imported.character);
    const Json after = written(imported, imported.character.surface);
    for (const char* word : {"\"targets\"", "targetNames", "\"weights\""})
      CHECK(after.dump().find(word) == std::string::npos);
  }

  TEST_CASE("eight influences take two sets whose weights sum to one") {
    Character c = bending_tube(6, 9, 9);
    for (Influences& influences : c.surface.influences) {
      influences.clear();
      for (int b = 0; b < 8; ++b) influences.push_back({b, (b + 1) / 36.0});
    }
    const std::vector<std::byte> glb = write_glb(c, c.surface);
    const Json attributes = json_of(glb)["meshes"][0]["primitives"][0]["attributes"];
    CHECK(attributes.contains("WEIGHTS_1"));
    CHECK(!attributes.contains("WEIGHTS_2"));
    for (const Influences& influences : import(chars(glb)).character.surface.influences) {
      REQUIRE(influences.size() == 8);
      double sum = 0;
      for (const Influence& influence : influences) sum += influence.weight;
      CHECK(std::abs(sum - 1) < 1e-7);
      CHECK(influences[7].weight == doctest::Approx(8 / 36.0));
    }
  }

  TEST_CASE("a node that is two joints stands twice in the skin") {
    Imported imported = import(sample_file().glb());
    Character& c = imported.character;
    Joint again = c.skeleton.joints[1];
    again.inverse_bind.col(3) += Vec3(0, 0.25, 0);
    c.skeleton.joints.push_back(again);
    c.surface.influences[5] = {{3, 1.0}};
    const std::vector<std::byte> glb = write_glb(c, c.surface, imported.document.get());
    const Json out = json_of(glb);
    CHECK(out["skins"][0]["joints"] == Json({1, 2, 5}));
    CHECK(out["nodes"][2]["children"] == Json({4, 5}));
    CHECK(difference(c, import(chars(glb)).character) < 1e-6);
  }

  TEST_CASE("joints of two trees are given a common root") {
    GltfFile file = sample_file();
    file.json["nodes"][0]["children"] = {3};
    file.json["scenes"][0]["nodes"] = {0, 1, 2};
    file.json["nodes"][1].erase("children");
    const Imported imported = import(file.glb());
    const std::vector<std::byte> glb =
        write_glb(imported.character, imported.character.surface, imported.document.get());
    CHECK(json_of(glb)["scenes"][0]["nodes"] == Json({0, 5}));
    CHECK(json_of(glb)["nodes"][5]["children"] == Json({1, 2}));
    check_same(imported.character, import(chars(glb)).character);
  }

  TEST_CASE("clips added to a glTF character are written too") {
    Imported imported = import(sample_file().glb());
    Clip run = imported.character.clips[0];
    run.name = "run";
    imported.character.clips.push_back(run);
    const Json out = written(imported, imported.character.surface);
    REQUIRE(out["animations"].size() == 2);
    CHECK(out["animations"][1]["name"] == "run");
    CHECK(out["animations"][1]["channels"].size() == 3);
  }

  TEST_CASE("a node that a new clip moves has no matrix and stands where it stood") {
    GltfFile file = sample_file();
    file.json["nodes"][2].erase("translation");
    const std::vector<double> matrix = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1};
    file.json["nodes"][2]["matrix"] = file.json["nodes"][4]["matrix"] = matrix;
    file.json["nodes"][4].erase("translation");
    file.json.erase("animations");
    Imported imported = import(file.glb());
    Character& c = imported.character;
    CHECK(written(imported, c.surface)["nodes"][2].contains("matrix"));
    c.clips = {{"shift", {{2, Path::Translation, Interpolation::Linear, {0}, Rows::Zero(1, 3)}}}};
    const std::vector<std::byte> glb = write_glb(c, c.surface, imported.document.get());
    const Json moved = json_of(glb)["nodes"][2];
    CHECK_FALSE(moved.contains("matrix"));
    CHECK(moved["translation"] == Json({0, 1, 0}));
    CHECK(json_of(glb)["nodes"][4].contains("matrix"));
    const Character back = import(chars(glb)).character;
    CHECK((affine(back.skeleton.nodes[2].rest) - affine(c.skeleton.nodes[2].rest)).norm() < 1e-9);
  }

  TEST_CASE("real characters come back the same") {
    struct Known {
      const char* path;
      int triangles, joints;
    };
    const Known files[] = {{"fox/Fox.glb", 576, 24},
                           {"cesium_man/CesiumMan.gltf", 4672, 19},
                           {"rigged_figure/RiggedFigure.glb", 256, 19},
                           {"robot_expressive/RobotExpressive.glb", 3237, 43 + 12},
                           {"mannequiny/mannequiny.glb", 13832, 45},
                           {"kaykit_knight/Knight.glb", 6952, 41 + 9},
                           {"makehuman_female/mh_female.glb", 41848, 163}};
    for (const Known& known : files) {
      const std::optional<std::string> path = content(known.path);
      if (!path) {
        MESSAGE("NOT TESTED: there is no " << known.path << "; set SKINLOD_CONTENT");
        continue;
      }
      CAPTURE(known.path);
      Imported imported = import_gltf(*path);
      Character& c = imported.character;
      CHECK(triangle_count(c.surface) == known.triangles);
      CHECK(int(c.skeleton.joints.size()) == known.joints);
      normalise(c.surface);
      for (const GltfDocument* document :
           {imported.document.get(), static_cast<const GltfDocument*>(nullptr)}) {
        const Imported back = import(chars(write_glb(c, c.surface, document)));
        CHECK(difference(c, back.character) < 1e-6);
        CHECK(c.surface.corners == back.character.surface.corners);
        CHECK(back.character.morphs.size() == c.morphs.size());
      }
    }
  }
}

}  // namespace skinlod
