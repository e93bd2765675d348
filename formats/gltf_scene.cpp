// SPDX-License-Identifier: MIT
#include "formats/gltf_scene.h"

#include <algorithm>
#include <map>
#include <string>

namespace skinlod {
namespace {

Json numbers(const auto& vector) {
  Json list = Json::array();
  for (const double x : vector) list.push_back(x);
  return list;
}

void set_rest(Json& json, const Transform& rest) {
  const Transform none;
  if (rest.translation != none.translation) json["translation"] = numbers(rest.translation);
  if (rest.rotation != none.rotation) json["rotation"] = numbers(rest.rotation.normalized());
  if (rest.scale != none.scale) json["scale"] = numbers(rest.scale);
}

Json node_of(const Node& node, bool is_moved) {
  Json json = Json::object();
  if (!node.name.empty()) json["name"] = node.name;
  if (node.matrix && !is_moved) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topRows<3>() = *node.matrix;
    json["matrix"] = numbers(matrix.reshaped());
    return json;
  }
  set_rest(json, node.rest);
  return json;
}

std::vector<bool> moved_nodes(const Character& character) {
  std::vector<bool> is_moved(character.skeleton.nodes.size(), false);
  for (const Clip& clip : character.clips) {
    for (const Channel& channel : clip.channels) {
      if (channel.path != Path::MorphWeights) is_moved[size_t(channel.node)] = true;
    }
  }
  return is_moved;
}

// A path that still means something beside the new file, as a URI; empty where it does not.
std::string relative_uri(const std::string& path) {
  constexpr std::string_view plain = "-._~/!$&'()+,;=@";
  if (path.empty() || path.find(':') != std::string::npos || path.find_first_of("/\\*") == 0) return {};
  std::string uri;
  for (const char c : path) {
    const bool is_plain =
        (c >= '0' && c <= '9') || ((c | 32) >= 'a' && (c | 32) <= 'z') || plain.find(c) != plain.npos;
    constexpr std::string_view digits = "0123456789ABCDEF";
    if (c == '\\') {
      uri += '/';
    } else if (is_plain) {
      uri += c;
    } else {
      uri += '%', uri += digits[size_t(c >> 4 & 15)], uri += digits[size_t(c & 15)];
    }
  }
  return uri;
}

const char* name_of(Path path) {
  switch (path) {
    case Path::Translation:
      return "translation";
    case Path::Rotation:
      return "rotation";
    case Path::Scale:
      return "scale";
    case Path::MorphWeights:
      return "weights";
  }
  return "";
}

const char* name_of(Interpolation interpolation) {
  switch (interpolation) {
    case Interpolation::Step:
      return "STEP";
    case Interpolation::Linear:
      return "LINEAR";
    case Interpolation::CubicSpline:
      return "CUBICSPLINE";
  }
  return "";
}

// The values as glTF stores them: one element per key and target for weights, unit quaternions.
Rows stored_values(const Channel& channel) {
  Rows values = channel.values;
  if (channel.path == Path::MorphWeights) return Eigen::Map<const Rows>(values.data(), values.size(), 1);
  if (channel.path == Path::Rotation && channel.interpolation != Interpolation::CubicSpline) {
    values.rowwise().normalize();
  }
  return values;
}

}  // namespace

void add_nodes(const Character& character, size_t first, Json& json) {
  const std::vector<Node>& nodes = character.skeleton.nodes;
  const std::vector<bool> is_moved = moved_nodes(character);
  for (size_t n = first; n < nodes.size(); ++n) json["nodes"].push_back(node_of(nodes[n], is_moved[n]));
  for (size_t n = first; n < nodes.size(); ++n) {
    if (nodes[n].parent >= 0) {
      json["nodes"][size_t(nodes[n].parent)]["children"].push_back(n);
    } else if (json.contains("scenes")) {
      json["scenes"][json.value("scene", size_t(0))]["nodes"].push_back(n);
    }
  }
}

// Textures come along where every part that shows them has coordinates.
void add_materials(const Character& character, Json& json) {
  std::map<std::string, size_t> textures;
  for (int m = 0; m < int(character.materials.size()); ++m) {
    const Material& material = character.materials[size_t(m)];
    Json& entry = json["materials"].emplace_back(Json::object());
    if (!material.name.empty()) entry["name"] = material.name;
    if (material.double_sided) entry["doubleSided"] = true;
    Json& colour = entry["pbrMetallicRoughness"];
    colour["baseColorFactor"] = numbers(material.base_colour.cwiseMax(0).cwiseMin(1));
    colour["metallicFactor"] = 0;
    const std::string uri = relative_uri(material.texture);
    const bool can_show = std::all_of(character.parts.begin(), character.parts.end(), [&](const Part& part) {
      return part.material != m || part.has.uv_sets > 0;
    });
    if (uri.empty() || !can_show) continue;
    const auto [place, fresh] = textures.try_emplace(uri, json["textures"].size());
    if (fresh) {
      json["textures"].push_back({{"source", json["images"].size()}});
      json["images"].push_back({{"uri", uri}});
    }
    colour["baseColorTexture"] = {{"index", place->second}};
  }
}

Json scene_of(const Character& character) {
  Json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
  json["scenes"].push_back({{"nodes", Json::array()}});
  add_nodes(character, 0, json);
  add_materials(character, json);
  return json;
}

void split_moved_matrices(const Character& character, Json& json) {
  const std::vector<bool> is_moved = moved_nodes(character);
  for (size_t n = 0; n < is_moved.size(); ++n) {
    Json& node = json["nodes"][n];
    if (!is_moved[n] || node.erase("matrix") == 0) continue;
    set_rest(node, character.skeleton.nodes[n].rest);
  }
}

void add_clips(std::span<const Clip> clips, const std::vector<bool>& has_morphs, GltfBuilder& glb) {
  for (const Clip& clip : clips) {
    std::map<std::vector<double>, int> times;  // channels of a clip mostly share their keys
    Json animation = {{"name", clip.name}, {"channels", Json::array()}, {"samplers", Json::array()}};
    for (const Channel& channel : clip.channels) {
      if (channel.path == Path::MorphWeights && !has_morphs[size_t(channel.node)]) continue;
      const auto [place, fresh] = times.try_emplace(channel.times, 0);
      if (fresh) {
        place->second = glb.add_floats(
            Eigen::Map<const VecX>(channel.times.data(), Eigen::Index(channel.times.size())), Use::Plain);
      }
      animation["channels"].push_back(
          {{"sampler", animation["samplers"].size()},
           {"target", {{"node", channel.node}, {"path", name_of(channel.path)}}}});
      animation["samplers"].push_back({{"input", place->second},
                                       {"interpolation", name_of(channel.interpolation)},
                                       {"output", glb.add_floats(stored_values(channel), Use::Plain)}});
    }
    if (!animation["channels"].empty()) glb.json["animations"].push_back(std::move(animation));
  }
}

}  // namespace skinlod
