// SPDX-License-Identifier: MIT
#include "formats/gltf.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "formats/gltf_document.h"
#include "pipeline/error.h"
#include "pipeline/pose.h"
#include "pipeline/repair.h"
#include "tests/formats/gltf_sample.h"
#include "tests/formats/scratch.h"

namespace skinlod {
namespace {

using Json = nlohmann::json;

Imported import(const GltfFile& file) {
  const Scratch folder;
  return import_gltf(folder.file("sample.glb", text(file.glb())));
}

// The message with which the file is refused; fails the test where it is not.
std::string refusal(const GltfFile& file) {
  try {
    import(file);
  } catch (const Error& e) {
    CHECK(e.fault == Fault::Input);
    return e.what();
  }
  FAIL("the file was read");
  return {};
}

std::int64_t count_of(const Imported& imported, WarningCode code) {
  std::int64_t count = 0;
  for (const Warning& warning : imported.warnings) count += warning.code == code ? warning.count : 0;
  return count;
}

bool says(const std::string& message, const std::string& fact) {
  return message.find(fact) != std::string::npos;
}

// All that is at a corner: position, attributes, weight of each joint, offset of each morph.
std::vector<double> corner(const Character& c, int wedge) {
  const Surface& s = c.surface;
  const int v = s.wedges[size_t(wedge)].vertex;
  std::vector<double> all(s.position[size_t(v)].data(), s.position[size_t(v)].data() + 3);
  for (const double x : s.attributes.row(wedge)) all.push_back(x);
  std::vector<double> weight(c.skeleton.joints.size(), 0), offset(6 * c.morphs.size(), 0);
  for (const Influence& influence : s.influences[size_t(v)])
    weight[size_t(influence.joint)] = influence.weight;
  for (const auto& [morphs, item, at] :
       {std::tuple(&s.morphs, v, 0), std::tuple(&s.normal_morphs, wedge, 3)}) {
    if (morphs->empty()) continue;
    for (const auto& [morph, delta] : (*morphs)[size_t(item)]) {
      std::copy_n(delta.data(), 3, offset.begin() + 6 * morph + at);
    }
  }
  all.insert(all.end(), weight.begin(), weight.end());
  all.insert(all.end(), offset.begin(), offset.end());
  return all;
}

// The faces as corners, whatever their order, indices and first corners: what a viewer sees. Numbers are
// compared to six digits.
std::vector<std::vector<std::vector<double>>> faces(const Character& c) {
  std::vector<std::vector<std::vector<double>>> all;
  for (int f = 0; f < c.surface.face_count(); ++f) {
    auto& face = all.emplace_back();
    face.push_back({double(c.surface.part(f))});
    for (const int wedge : c.surface.face(f)) face.push_back(corner(c, wedge));
    for (auto& values : face) {
      for (double& x : values) x = std::round(x * 1e6) / 1e6 + 0.0;
    }
    std::rotate(face.begin() + 1, std::min_element(face.begin() + 1, face.end()), face.end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

// Twice the area of a face as a vector along its front.
Vec3 front(const Surface& s, int f) {
  const auto at = [&](size_t i) { return s.position[size_t(s.wedges[size_t(s.face(f)[i])].vertex)]; };
  return (at(1) - at(0)).cross(at(2) - at(0));
}

}  // namespace

TEST_SUITE("gltf") {
  TEST_CASE("the sample is read as it was made") {
    const Imported imported = import(sample_file());
    const Character& c = imported.character;
    CHECK(c.name == "sample");
    CHECK(imported.warnings.empty());
    REQUIRE(c.skeleton.nodes.size() == 5);
    CHECK(c.skeleton.nodes[2].name == "knee");
    CHECK(c.skeleton.nodes[2].parent == 1);
    REQUIRE(c.skeleton.joints.size() == 3);  // hip, knee, and the prop's node
    CHECK(c.skeleton.joints[2].node == 4);
    REQUIRE(c.parts.size() == 2);
    CHECK(c.parts[0].name == "body");
    CHECK(c.parts[0].material == 0);
    CHECK(c.parts[0].has ==
          AttributeLayout{.normal = true, .tangent = false, .uv_sets = 1, .colour_sets = 0});
    CHECK(c.parts[1].has ==
          AttributeLayout{.normal = true, .tangent = false, .uv_sets = 0, .colour_sets = 0});
    REQUIRE(c.materials.size() == 1);
    CHECK(c.materials[0].base_colour == Vec4(0.5, 0.25, 1, 1));
    CHECK(c.materials[0].double_sided);
    REQUIRE(c.surface.position.size() == 9);
    CHECK(c.surface.position[5] == Vec3(1, 1, 1));
    CHECK(c.surface.position[8] == Vec3(0, 1, 2));  // the prop stands at the knee and one forward
    CHECK(c.surface.influences[0] == Influences{{0, 1.0}});
    REQUIRE(c.surface.influences[2].size() == 2);
    CHECK(c.surface.influences[2][1].joint == 1);
    CHECK(c.surface.influences[2][1].weight == doctest::Approx(0.8));
    CHECK(c.surface.influences[8] == Influences{{2, 1.0}});
    CHECK(c.surface.face_count() == 5);
    REQUIRE(c.morphs.size() == 1);
    CHECK(c.morphs[0].name == "bulge");
    REQUIRE(c.surface.morphs.size() == 9);
    REQUIRE(c.surface.morphs[3].size() == 1);
    CHECK(c.surface.morphs[3][0].delta == Vec3(0, 0, 1));
    CHECK(c.surface.normal_morphs[3][0].delta == Vec3(0, 1, 0));
    REQUIRE(c.clips.size() == 1);
    REQUIRE(c.clips[0].channels.size() == 3);
    CHECK(c.clips[0].channels[0].interpolation == Interpolation::Linear);
    CHECK(c.clips[0].channels[1].interpolation == Interpolation::CubicSpline);
    CHECK(c.clips[0].channels[1].values.rows() == 6);
    CHECK(c.clips[0].channels[2].interpolation == Interpolation::Step);
    CHECK(c.clips[0].channels[2].values.rows() == 2);
  }

  TEST_CASE("every legal encoding makes the same character") {
    const auto expected = faces(import(sample_file()).character);
    std::vector<SampleOptions> variants;
    for (const int type : {5121, 5123}) variants.push_back({.joints_type = type, .two_sets = true});
    for (const int type : {5121, 5123}) variants.push_back({.joints_type = 5123, .weights_type = type});
    for (const int type : {0, 5121, 5123, 5125}) variants.push_back({.index_type = type});
    for (const int type : {0, 5123}) variants.push_back({.index_type = type, .strip = true});
    for (const int type : {5120, 5121, 5122, 5123}) {
      variants.push_back({.position_type = type, .uv_type = type});
      variants.push_back(
          {.position_type = type, .position_normalised = true, .uv_type = type, .uv_normalised = true});
    }
    for (const int type : {5120, 5122}) variants.push_back({.normal_type = type});
    for (size_t i = 0; i < variants.size(); ++i) {
      CAPTURE(i);
      GltfFile file = sample_file(variants[i]);
      file.json["extensionsRequired"] = file.json["extensionsUsed"] = {"KHR_mesh_quantization"};
      CHECK(faces(import(file).character) == expected);
    }
  }

  TEST_CASE("a fan is the triangles around its first corner") {
    const auto with = [](int mode, const std::vector<double>& corners) {
      GltfFile file = sample_file();
      Json& primitive = file.json["meshes"][0]["primitives"][0];
      primitive["mode"] = mode;
      primitive["indices"] = file.accessor(corners, "SCALAR", 5123);
      return faces(import(file).character);
    };
    CHECK(with(6, {2, 0, 1, 3, 4}) == with(4, {0, 1, 2, 1, 3, 2, 3, 4, 2}));
  }

  TEST_CASE("strips skip the corners that they turn on") {
    GltfFile file = sample_file();
    Json& primitive = file.json["meshes"][0]["primitives"][0];
    primitive["mode"] = 5;
    primitive["indices"] = file.accessor({0, 1, 2, 2, 3, 3, 4, 5}, "SCALAR", 5123);
    CHECK(import(file).character.surface.face_count() == 2 + 1);  // 0 1 2, 3 5 4, and the prop
  }

  TEST_CASE("a file may stand in one piece or in pieces beside it") {
    const Scratch folder;
    GltfFile file = sample_file();
    const auto expected = faces(import(file).character);
    while (file.buffer.size() % 3 != 0) file.buffer.push_back(0);  // so that base64 needs no padding
    const std::string binary(file.buffer.begin(), file.buffer.end());
    folder.file("the buffer+1%.bin", binary);
    file.json["buffers"] = {{{"uri", "the%20buffer+1%25.bin"}, {"byteLength", file.buffer.size()}}};
    const Imported beside = import_gltf(folder.file("beside.gltf", file.json.dump()));
    CHECK(faces(beside.character) == expected);
    REQUIRE(beside.files_read.size() == 2);
    CHECK(beside.files_read[1].ends_with("the buffer+1%.bin"));

    constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string base64;
    for (size_t i = 0; i + 2 < binary.size(); i += 3) {
      const auto byte = [&](size_t k) { return unsigned((unsigned char)(binary[i + k])); };
      const unsigned bits = byte(0) << 16 | byte(1) << 8 | byte(2);
      for (int shift = 18; shift >= 0; shift -= 6) base64 += digits[bits >> shift & 63];
    }
    file.json["buffers"][0]["uri"] = "data:application/gltf-buffer;base64," + base64;
    CHECK(faces(import_gltf(folder.file("inside.gltf", file.json.dump())).character) == expected);
  }

  TEST_CASE("sparse values replace what they are laid over") {
    GltfFile file = sample_file();
    const auto expected = faces(import(file).character);
    Json& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
    Json& position = file.json["accessors"][attributes["POSITION"].get<size_t>()];
    const auto view_of = [&](int accessor) { return file.json["accessors"][size_t(accessor)]["bufferView"]; };
    SUBCASE("over zeros") {
      const int values = file.accessor({1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 1, 1, 1}, "VEC3");
      const int indices = file.accessor({1, 2, 3, 4, 5}, "SCALAR", 5123);
      file.json["bufferViews"].back().erase("byteStride");
      file.json["accessors"][attributes["POSITION"].get<size_t>()].erase("bufferView");
      file.json["accessors"][attributes["POSITION"].get<size_t>()]["sparse"] = {
          {"count", 5},
          {"indices", {{"bufferView", view_of(indices)}, {"componentType", 5123}}},
          {"values", {{"bufferView", view_of(values)}}}};
    }
    SUBCASE("over wrong values") {
      std::fill_n(file.buffer.begin() +
                      file.json["bufferViews"][position["bufferView"].get<size_t>()]["byteOffset"].get<int>(),
                  12, (unsigned char)(7));
      const int values = file.accessor({0, 0, 0}, "VEC3");
      const int indices = file.accessor({0}, "SCALAR", 5121);
      file.json["accessors"][attributes["POSITION"].get<size_t>()]["sparse"] = {
          {"count", 1},
          {"indices", {{"bufferView", view_of(indices)}, {"componentType", 5121}}},
          {"values", {{"bufferView", view_of(values)}}}};
    }
    CHECK(faces(import(file).character) == expected);
  }

  TEST_CASE("only the default scene is shown") {
    GltfFile file = sample_file();
    file.json["nodes"].push_back({{"name", "elsewhere"}, {"mesh", 1}});
    file.json["scenes"] = {{{"nodes", {5}}}, {{"nodes", {0}}}};
    file.json["scene"] = 1;
    const Imported imported = import(file);
    CHECK(imported.character.parts.size() == 2);
    CHECK(count_of(imported, WarningCode::MeshOutsideScene) == 1);
    CHECK(imported.warnings[0].part == "elsewhere");
    file.json.erase("scene");
    CHECK(says(refusal(file), "no skin"));
    file.json.erase("scenes");
    CHECK(import(file).character.parts.size() == 3);
  }

  TEST_CASE("the transforms above a skinned mesh do not move it") {
    GltfFile file = sample_file();
    const auto expected = faces(import(file).character);
    file.json["nodes"][0]["children"] = {1, 5};
    file.json["nodes"].push_back({{"children", {3}}, {"translation", {5, 5, 5}}, {"scale", {2, -3, 1}}});
    file.json["nodes"][3]["rotation"] = {1, 0, 0, 0};
    CHECK(faces(import(file).character) == expected);
  }

  TEST_CASE("a mirrored node turns its faces about so that they still look along their normals") {
    GltfFile file = sample_file();
    file.json["nodes"][4]["scale"] = {-2, 1, 3};
    const Imported imported = import(file);
    const Surface& s = imported.character.surface;
    const int last = s.face_count() - 1;
    CHECK(s.position[7] == Vec3(-2, 1, 1));
    const Vec3 normal = s.attributes.row(8).segment<3>(0).transpose();
    CHECK(normal == Vec3(0, -1, 0));
    CHECK(front(s, last).normalized() == normal);

    const Scratch folder;
    for (const GltfDocument* document :
         {imported.document.get(), static_cast<const GltfDocument*>(nullptr)}) {
      const std::vector<std::byte> bytes = write_glb(imported.character, s, document);
      const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
      CHECK(faces(import_gltf(folder.file("back.glb", text(std::span(data, bytes.size())))).character) ==
            faces(imported.character));
    }
  }

  TEST_CASE("a mesh at two nodes is two parts on two joints") {
    GltfFile file = sample_file();
    file.json["nodes"].push_back({{"name", "second prop"}, {"mesh", 1}, {"translation", {3, 0, 0}}});
    file.json["nodes"][1]["children"].push_back(5);
    const Character c = import(file).character;
    REQUIRE(c.parts.size() == 3);
    CHECK(c.parts[2].node == 5);
    CHECK(c.surface.influences[9][0].joint != c.surface.influences[8][0].joint);
    CHECK(c.surface.position[9] == Vec3(3, 0, 0));
  }

  TEST_CASE("rotations and morph weights may be normalised integers") {
    GltfFile file = sample_file();
    Json& samplers = file.json["animations"][0]["samplers"];
    samplers[0]["output"] = file.accessor({0, 0, 0, 1, 1, 0, 0, 0}, "VEC4", 5122, true);
    samplers[2]["output"] = file.accessor({0, 1}, "SCALAR", 5121, true);
    const Character c = import(file).character;
    CHECK(c.clips[0].channels[0].values.row(1) == Eigen::RowVector4d(1, 0, 0, 0));
    CHECK(c.clips[0].channels[2].values(1, 0) == 1);
  }

  TEST_CASE("channels with broken keys are left out and counted") {
    GltfFile file = sample_file();
    Json& samplers = file.json["animations"][0]["samplers"];
    samplers[0]["input"] = file.accessor({0, std::nan("")}, "SCALAR");
    samplers[1]["output"] = file.accessor(std::vector<double>(18, std::nan("")), "VEC3");
    const Imported imported = import(file);
    CHECK(imported.character.clips[0].channels.size() == 1);
    REQUIRE(imported.warnings.size() == 1);
    CHECK(imported.warnings[0].code == WarningCode::ClipValuesNotFinite);
    CHECK(imported.warnings[0].count == 2);
  }

  TEST_CASE("keys out of order or at one time are left for repair to sort and are written in order") {
    GltfFile file = sample_file();
    Json& samplers = file.json["animations"][0]["samplers"];
    samplers[0]["input"] = file.accessor({1, 0}, "SCALAR");
    samplers[1]["input"] = file.accessor({2, 2}, "SCALAR");
    Imported imported = import(file);
    CHECK(imported.warnings.empty());
    REQUIRE(imported.character.clips[0].channels.size() == 3);
    const Warnings warnings = repair(imported.character);
    CHECK(warnings.size() == 2);
    const Character& c = imported.character;
    CHECK(c.clips[0].channels[0].times == std::vector<double>{0, 1});
    CHECK(c.clips[0].channels[1].times == std::vector<double>{2});

    const std::vector<std::byte> glb = write_glb(c, c.surface, imported.document.get());
    const auto* data = reinterpret_cast<const unsigned char*>(glb.data());
    const Scratch folder;
    const Character back = import_gltf(folder.file("back.glb", text(std::span(data, glb.size())))).character;
    REQUIRE(back.clips[0].channels.size() == 3);
    for (size_t i = 0; i < 3; ++i) {
      CHECK(back.clips[0].channels[i].times == c.clips[0].channels[i].times);
      CHECK(back.clips[0].channels[i].values == c.clips[0].channels[i].values);
    }
  }

  TEST_CASE("what stands twice in a list is read and written once") {
    GltfFile file = sample_file();
    file.json["scenes"][0]["nodes"] = {0, 0};
    Json& channels = file.json["animations"][0]["channels"];
    Json again = channels[0];
    again["extras"] = "the second";
    channels.push_back(again);
    const Imported imported = import(file);
    CHECK(count_of(imported, WarningCode::SceneNodeTwice) == 1);
    CHECK(count_of(imported, WarningCode::ClipChannelsTwice) == 1);
    CHECK(imported.character.clips[0].channels.size() == 3);
    CHECK(imported.document->json["scenes"][0]["nodes"] == Json::array({0}));
    CHECK(imported.document->json["animations"][0]["channels"].size() == 3);
    CHECK_FALSE(imported.document->json["animations"][0]["channels"][0].contains("extras"));
  }

  TEST_CASE("nothing of the geometry is mended without a word") {
    GltfFile file = sample_file();
    Json& primitive = file.json["meshes"][0]["primitives"][0];
    SUBCASE("indices that are too few for a triangle") {
      primitive["indices"] = file.accessor({0, 1, 2, 1, 3}, "SCALAR", 5123);
      const Imported imported = import(file);
      CHECK(count_of(imported, WarningCode::FaceIncomplete) == 2);
      CHECK(imported.warnings[0].part == "body");
      CHECK(imported.character.surface.face_count() == 2);
    }
    SUBCASE("a strip of two corners") {
      primitive["mode"] = 5;
      primitive["indices"] = file.accessor({0, 1}, "SCALAR", 5123);
      CHECK(count_of(import(file), WarningCode::FaceIncomplete) == 2);
      primitive["indices"] = file.accessor({0, 1, 2, 3}, "SCALAR", 5123);
      CHECK(count_of(import(file), WarningCode::FaceIncomplete) == 0);
    }
    SUBCASE("a rotation of zeros") {
      file.json["nodes"][2]["rotation"] = {0, 0, 0, 0};
      const Imported imported = import(file);
      CHECK(count_of(imported, WarningCode::RotationZero) == 1);
      CHECK(imported.warnings[0].part == "knee");
      CHECK(imported.character.skeleton.nodes[2].rest.rotation == Quat(0, 0, 0, 1));
      CHECK_FALSE(imported.document->json["nodes"][2].contains("rotation"));
    }
    SUBCASE("a negative weight beside a positive one on the same joint") {
      std::vector<double> weights(24, 0);
      for (size_t i = 0; i < 24; i += 4) weights[i] = 1;
      weights[0] = 1.5, weights[1] = -0.5;
      primitive["attributes"]["JOINTS_0"] = file.accessor(std::vector<double>(24, 0), "VEC4", 5121);
      primitive["attributes"]["WEIGHTS_0"] = file.accessor(weights, "VEC4");
      Imported imported = import(file);
      const Warnings warnings = repair(imported.character);
      CHECK(std::count_if(warnings.begin(), warnings.end(), [](const Warning& warning) {
              return warning.code == WarningCode::WeightsNegative && warning.count == 1;
            }) == 1);
    }
  }

  TEST_CASE("what is no part of a skin is counted") {
    GltfFile file = sample_file();
    file.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}};
    file.json["nodes"][0]["camera"] = 0;
    Json points = file.json["meshes"][1]["primitives"][0];
    points["mode"] = 0;
    file.json["meshes"][1]["primitives"].push_back(points);
    const Imported imported = import(file);
    CHECK(imported.character.parts.size() == 2);
    REQUIRE(imported.warnings.size() == 2);
    for (const Warning& warning : imported.warnings) CHECK(warning.code == WarningCode::NotASkinFeature);
  }

  TEST_CASE("corners and joints that are not there are left for repair to find") {
    GltfFile file = sample_file();
    Json& primitive = file.json["meshes"][0]["primitives"][0];
    primitive["indices"] = file.accessor({0, 1, 2, 1, 3, 9}, "SCALAR", 5123);
    primitive["attributes"]["JOINTS_0"] = file.accessor(std::vector<double>(24, 7), "VEC4", 5121);
    const Surface s = import(file).character.surface;
    CHECK(s.face(1)[2] == -1);
    CHECK(s.influences[0] == Influences{{-1, 1.0}});
  }

  TEST_CASE("a file that cannot be a character is refused with the reason") {
    GltfFile file = sample_file();
    SUBCASE("no skin") {
      file.json["nodes"][3].erase("skin");
      CHECK(says(refusal(file), "no skin"));
    }
    SUBCASE("no faces") {
      file.json["meshes"][0]["primitives"][0]["mode"] = 1;
      file.json["meshes"][1]["primitives"][0]["mode"] = 0;
      CHECK(says(refusal(file), "no faces"));
    }
    SUBCASE("packed by an extension") {
      file.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
      const std::string message = refusal(file);
      CHECK(says(message, "KHR_draco_mesh_compression"));
      CHECK(says(message, "uncompressed"));
    }
    SUBCASE("another version") {
      file.json["asset"]["version"] = "1.0";
      CHECK(says(refusal(file), "glTF 1.0"));
    }
    SUBCASE("a version that needs a newer reader") {
      file.json["asset"]["version"] = "2.1";
      CHECK(import(file).character.parts.size() == 2);
      file.json["asset"]["minVersion"] = "2.0";
      CHECK(import(file).character.parts.size() == 2);
      file.json["asset"]["minVersion"] = "2.1";
      CHECK(says(refusal(file), "needs a reader of glTF 2.1"));
    }
  }

  TEST_CASE("a lie about any index or size is found and named") {
    struct Lie {
      std::string at;  // a JSON pointer
      Json value;
      const char* fact;
    };
    const Lie lies[] = {
        {"/accessors/0/count", 7, "accessor 0: runs 12 bytes past its buffer view: re-export the file"},
        {"/accessors/0/count", 0, "has 0 elements"},
        {"/accessors/0/count", 18446744073709551615u, "brings the vertices to 4294967296"},
        {"/accessors/0/count", 67108864, "brings the vertices to 67108864"},
        {"/accessors/1/count", 18446744073709551615u, "elements"},
        {"/accessors/1/count", 67108864, "bytes past"},
        {"/accessors/0/count", -6, "wrong type"},
        {"/accessors/0/byteOffset", 4, "runs 4 bytes past"},
        {"/accessors/0/byteOffset", 18446744073709551612u, "bytes past"},
        {"/accessors/0/componentType", 5124, "component type 5124"},
        {"/accessors/0/componentType", 5125, "not allowed"},
        {"/accessors/0/type", "VEC4", "overlap"},
        {"/accessors/0/type", "VEC2", "not allowed"},
        {"/accessors/0/bufferView", 999, "buffer view 999 does not exist"},
        {"/accessors/0/bufferView", 4294967296u, "wrong type"},
        {"/accessors/0/bufferView", -1, "wrong type"},
        {"/bufferViews/0/buffer", 1, "buffer 1 does not exist"},
        {"/bufferViews/0/byteOffset", 1000000, "runs past the"},
        {"/bufferViews/0/byteLength", 1000000, "runs past the"},
        {"/bufferViews/0/byteStride", 4, "overlap"},
        {"/bufferViews/0/byteStride", 252, "bytes past"},
        {"/meshes/0/primitives/0/attributes/POSITION", 999, "accessor 999: does not exist"},
        {"/meshes/0/primitives/0/attributes/NORMAL", 0, ""},
        {"/meshes/0/primitives/0/attributes/TEXCOORD_0", 0, "not allowed"},
        {"/meshes/0/primitives/0/attributes/JOINTS_0", 0, "not allowed"},
        {"/meshes/0/primitives/0/indices", 0, "not allowed"},
        {"/meshes/0/primitives/0/indices", 4294967296u, "wrong type"},
        {"/meshes/0/primitives/0/material", 9, "material"},
        {"/meshes/0/primitives/0/mode", 9, "mode 9"},
        {"/meshes/0/primitives/0/targets/0/POSITION", 999, "does not exist"},
        {"/meshes/0/primitives", "none", "no object"},
        {"/nodes", 3, "is no list"},
        {"/nodes/1", nullptr, "nodes[1]: is no object"},
        {"/images", {nullptr}, "images[0]: is no object"},
        {"/nodes/1/children", {9}, "child 9 does not exist"},
        {"/nodes/1/children", {2, 2}, "two parents"},
        {"/nodes/2/children", {0}, "circle"},
        {"/nodes/0/children", {0}, "circle"},
        {"/nodes/4/children", {4}, ""},
        {"/nodes/1/matrix", {1, 2, 3}, "wrong length"},
        {"/nodes/2/translation", {1}, "wrong length"},
        {"/nodes/3/mesh", 9, "mesh 9 does not exist"},
        {"/nodes/3/skin", 9, "skin 9: does not exist"},
        {"/skins/0/joints", {1, 9}, "joint 9 does not exist"},
        {"/skins/0/joints", Json::array(), "no joints"},
        {"/skins/0/joints", {1, 2, 3}, "fewer inverse bind matrices"},
        {"/skins/0/inverseBindMatrices", 0, "not allowed"},
        {"/scenes/0/nodes", {9}, "node 9 does not exist"},
        {"/scene", 3, "scene 3: does not exist"},
        {"/animations/0/channels/0/sampler", 9, "sampler does not exist"},
        {"/animations/0/channels/0/target/node", 9, "node does not exist"},
        {"/animations/0/samplers/0/output", 0, "not allowed"},
        {"/animations/0/samplers/0/input", 0, "not allowed"},
        {"/animations/0/samplers/0/interpolation", "BEZIER", "BEZIER"},
    };
    for (const Lie& lie : lies) {
      CAPTURE(lie.at);
      CAPTURE(lie.value.dump());
      GltfFile file = sample_file();
      file.json[Json::json_pointer(lie.at)] = lie.value;
      if (lie.at.ends_with("NORMAL")) file.json["accessors"][0]["componentType"] = 5121;
      const std::string message = refusal(file);
      CAPTURE(message);
      CHECK(says(message, "sample.glb: "));
      CHECK(says(message, lie.fact));
    }
  }

  TEST_CASE("sparse lies are found") {
    for (const auto& [indices, count, fact] : {std::tuple(std::vector<double>{1, 1}, 2, "does not ascend"),
                                               std::tuple(std::vector<double>{1, 6}, 2, "out of range"),
                                               std::tuple(std::vector<double>{1, 2}, 7, "replaces 7 of 6"),
                                               std::tuple(std::vector<double>{1, 2}, 3, "past")}) {
      GltfFile file = sample_file();
      const int values = file.accessor({0, 0, 0, 0, 0, 0}, "VEC3"),
                places = file.accessor(indices, "SCALAR", 5121);
      file.json["accessors"][0]["sparse"] = {
          {"count", count},
          {"indices",
           {{"bufferView", file.json["accessors"][size_t(places)]["bufferView"]}, {"componentType", 5121}}},
          {"values", {{"bufferView", file.json["accessors"][size_t(values)]["bufferView"]}}}};
      CHECK(says(refusal(file), fact));
    }
  }

  TEST_CASE("JSON nested without end is refused") {
    const Scratch folder;
    const std::string deep = R"({"asset": {"version": "2.0", "extras": )" + std::string(1000000, '[');
    CHECK_THROWS_AS(import_gltf(folder.file("deep.gltf", deep)), Error);
  }

  TEST_CASE("a texture that is missing does not matter and one that is there is kept") {
    GltfFile file = sample_file();
    file.json["images"] = {{{"uri", "missing.png"}}, {{"uri", "there.png"}}};
    file.json["textures"] = {{{"source", 0}}, {{"source", 1}}};
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 1}};
    const Scratch folder;
    folder.file("there.png", std::string("\x89PNG and so on"));
    const Imported imported = import_gltf(folder.file("sample.glb", text(file.glb())));
    CHECK(imported.files_read.size() == 2);
    CHECK(imported.character.materials[0].texture == "there.png");
    const std::vector<std::byte> glb =
        write_glb(imported.character, imported.character.surface, imported.document.get());
    const std::string out(reinterpret_cast<const char*>(glb.data()), glb.size());
    CHECK(says(out, "\x89PNG and so on"));
    CHECK(says(out, "missing.png"));
    CHECK(!says(out, "there.png"));
  }
}

}  // namespace skinlod
