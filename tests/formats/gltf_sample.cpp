// SPDX-License-Identifier: MIT
#include "tests/formats/gltf_sample.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>

namespace skinlod {
namespace {

using Json = nlohmann::json;

template <class T>
void append(std::vector<unsigned char>& out, T value) {
  unsigned char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.insert(out.end(), bytes, bytes + sizeof value);
}

void encode(std::vector<unsigned char>& out, double value, int type, bool normalised) {
  static const std::map<int, double> largest = {{5120, 127}, {5121, 255}, {5122, 32767}, {5123, 65535}};
  if (normalised) value = std::round(value * largest.at(type));
  switch (type) {
    case 5120:
      return append(out, std::int8_t(value));
    case 5121:
      return append(out, std::uint8_t(value));
    case 5122:
      return append(out, std::int16_t(value));
    case 5123:
      return append(out, std::uint16_t(value));
    case 5125:
      return append(out, std::uint32_t(value));
    default:
      return append(out, float(value));
  }
}

size_t component_count(const std::string& type) {
  return type == "SCALAR" ? 1 : type == "MAT4" ? 16 : size_t(type.back() - '0');
}

// A column-major matrix that moves by -height along y.
std::vector<double> bind_at(double height) { return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -height, 0, 1}; }

std::vector<double> joined(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::vector<double> gathered(const std::vector<double>& values, size_t components,
                             const std::vector<double>& items) {
  std::vector<double> out;
  for (const double item : items) {
    for (size_t i = 0; i < components; ++i) out.push_back(values[size_t(item) * components + i]);
  }
  return out;
}

}  // namespace

int GltfFile::view(std::span<const unsigned char> bytes) {
  while (buffer.size() % 4 != 0) buffer.push_back(0);
  json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}});
  buffer.insert(buffer.end(), bytes.begin(), bytes.end());
  return int(json["bufferViews"].size()) - 1;
}

int GltfFile::accessor(const std::vector<double>& values, const std::string& type, int component_type,
                       bool normalised) {
  // vertex data stands at multiples of four bytes
  const size_t components = component_count(type);
  std::vector<unsigned char> bytes;
  size_t stride = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    encode(bytes, values[i], component_type, normalised);
    if ((i + 1) % components != 0 || type == "SCALAR") continue;
    while (bytes.size() % 4 != 0) bytes.push_back(0);
    if (i + 1 == components) stride = bytes.size();
  }
  Json entry = {{"bufferView", view(bytes)},
                {"componentType", component_type},
                {"count", values.size() / components},
                {"type", type}};
  if (normalised) entry["normalized"] = true;
  if (stride > 0 && stride < 64) json["bufferViews"].back()["byteStride"] = stride;
  json["accessors"].push_back(entry);
  return int(json["accessors"].size()) - 1;
}

std::vector<unsigned char> GltfFile::glb() const {
  Json whole = json;
  std::vector<unsigned char> binary = buffer;
  while (binary.size() % 4 != 0) binary.push_back(0);
  Json buffers = Json::array({{{"byteLength", binary.size()}}});
  for (const Json& beside : whole["buffers"]) buffers.push_back(beside);
  whole["buffers"] = buffers;
  std::string text = whole.dump();
  while (text.size() % 4 != 0) text += ' ';
  std::vector<unsigned char> file;
  append(file, std::uint32_t(0x46546C67)), append(file, std::uint32_t(2));
  append(file, std::uint32_t(28 + text.size() + binary.size()));
  append(file, std::uint32_t(text.size())), append(file, std::uint32_t(0x4E4F534A));
  file.insert(file.end(), text.begin(), text.end());
  append(file, std::uint32_t(binary.size())), append(file, std::uint32_t(0x004E4942));
  file.insert(file.end(), binary.begin(), binary.end());
  return file;
}

GltfFile sample_file(const SampleOptions& options) {
  std::vector<double> position = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 1, 1, 1};
  std::vector<double> normal = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, -1, 0, 0, -1, 0};
  std::vector<double> uv = {0, 0, 1, 0, 0, 1, 1, 1, 1, 0, 0, 1};
  std::vector<double> joints = {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  std::vector<double> weights = {1, 0, 0, 0, 1, 0, 0, 0, .2, .8, 0, 0, .2, .8, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  std::vector<double> bulge = {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0};
  std::vector<double> bulge_normal = {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0};
  std::vector<double> corners = {0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4};
  if (options.strip) corners = {0, 1, 2, 3, 4, 5};
  if (options.index_type == 0) {
    for (auto* three : {&position, &normal, &bulge, &bulge_normal}) *three = gathered(*three, 3, corners);
    for (auto* four : {&joints, &weights}) *four = gathered(*four, 4, corners);
    uv = gathered(uv, 2, corners);
  }
  GltfFile file;
  const auto add = [&](const auto&... arguments) { return file.accessor(arguments...); };
  Json attributes = {{"POSITION", add(position, "VEC3", options.position_type, options.position_normalised)},
                     {"NORMAL", add(normal, "VEC3", options.normal_type, options.normal_type != 5126)},
                     {"TEXCOORD_0", add(uv, "VEC2", options.uv_type, options.uv_normalised)}};
  const bool normalised = options.weights_type != 5126;
  if (options.two_sets) {
    std::vector<double> first = weights, second = weights, joint = joints;
    for (size_t i = 0; i < weights.size(); ++i) {
      (i % 4 == 0 ? second[i] : first[i]) = 0;
      if (i % 4 != 0 && weights[i] == 0) joint[i] = 0;
    }
    attributes["JOINTS_0"] = add(joints, "VEC4", options.joints_type);
    attributes["WEIGHTS_0"] = add(first, "VEC4", options.weights_type, normalised);
    attributes["JOINTS_1"] = add(joint, "VEC4", options.joints_type);
    attributes["WEIGHTS_1"] = add(second, "VEC4", options.weights_type, normalised);
  } else {
    attributes["JOINTS_0"] = add(joints, "VEC4", options.joints_type);
    attributes["WEIGHTS_0"] = add(weights, "VEC4", options.weights_type, normalised);
  }
  Json body = {{"attributes", attributes},
               {"material", 0},
               {"mode", options.strip ? 5 : 4},
               {"targets", {{{"POSITION", add(bulge, "VEC3")}, {"NORMAL", add(bulge_normal, "VEC3")}}}}};
  if (options.index_type != 0) body["indices"] = add(corners, "SCALAR", options.index_type);
  const int prop = file.accessor({0, 0, 0, 1, 0, 0, 0, 0, 1}, "VEC3");
  const int facing = file.accessor({0, -1, 0, 0, -1, 0, 0, -1, 0}, "VEC3");
  const int binds = file.accessor(joined(bind_at(0), bind_at(1)), "MAT4");

  const int times = file.accessor({0, 1}, "SCALAR");
  const double half = std::sqrt(0.5);
  const int turn = file.accessor({0, 0, 0, 1, half, 0, 0, half}, "VEC4");
  const int lift = file.accessor({0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0}, "VEC3");
  const int swell = file.accessor({0, 1}, "SCALAR");

  file.json.update(Json::parse(R"({
    "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "root", "children": [1, 3]},
              {"name": "hip", "children": [2]},
              {"name": "knee", "translation": [0, 1, 0], "children": [4]},
              {"name": "body", "mesh": 0, "skin": 0},
              {"name": "prop", "mesh": 1, "translation": [0, 0, 1]}],
    "materials": [{"name": "skin", "doubleSided": true,
                   "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 1]}}],
    "skins": [{"joints": [1, 2]}]})"));
  file.json["skins"][0]["inverseBindMatrices"] = binds;
  file.json["meshes"] = {
      {{"name", "body"},
       {"primitives", {body}},
       {"weights", {0.0}},
       {"extras", {{"targetNames", {"bulge"}}}}},
      {{"name", "prop"}, {"primitives", {{{"attributes", {{"POSITION", prop}, {"NORMAL", facing}}}}}}}};
  const auto channel = [](int sampler, int node, const char* path) {
    return Json{{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}};
  };
  file.json["animations"] = {
      {{"name", "walk"},
       {"channels", {channel(0, 2, "rotation"), channel(1, 1, "translation"), channel(2, 3, "weights")}},
       {"samplers",
        {{{"input", times}, {"output", turn}},
         {{"input", times}, {"output", lift}, {"interpolation", "CUBICSPLINE"}},
         {{"input", times}, {"output", swell}, {"interpolation", "STEP"}}}}}};
  return file;
}

}  // namespace skinlod
