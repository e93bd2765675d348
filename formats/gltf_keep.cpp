// SPDX-License-Identifier: MIT
#include "formats/gltf_keep.h"

#include <algorithm>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/gltf_accessor.h"
#include "pipeline/repair.h"

namespace skinlod {
namespace {

// How vertices and their bytes are packed is ours to say.
constexpr const char* kPacking[] = {"EXT_meshopt_compression", "KHR_draco_mesh_compression",
                                    "KHR_meshopt_compression", "KHR_mesh_quantization"};

// Moves accessors and buffer views over to the builder, each once.
class Mover {
 public:
  Mover(const GltfDocument& doc, GltfBuilder& glb) : doc_(doc), glb_(glb) {}

  // Elements that are not vertices: their views have no stride.
  int accessor(int index) {
    const auto [place, fresh] = accessors_.try_emplace(index, 0);
    if (!fresh) return place->second;
    const Elements elements = read_elements(doc_, index);
    Json entry = entry_of(index);
    spend(elements.bytes.size());
    if (is_scalar_float(elements)) {
      // exporters get the bounds of key times wrong, and validators look
      const Rows values = read_rows(doc_, index, Legal::Float, {TINYGLTF_TYPE_SCALAR});
      entry["min"] = {values.minCoeff()}, entry["max"] = {values.maxCoeff()};
    }
    return place->second = glb_.add_elements(std::move(entry), elements.bytes, elements.size, Use::Plain);
  }

  // A sampler's accessors. glTF forbids keys that are out of order or at one time.
  void sampler(Json& json) {
    const int input = json["input"].get<int>(), output = json["output"].get<int>();
    const std::vector<size_t>& keys = mended_keys(input);
    if (keys.empty()) {
      json["input"] = accessor(input), json["output"] = accessor(output);
    } else {
      json["input"] = picked(input, input, keys), json["output"] = picked(output, input, keys);
    }
  }

  int view(int index) {
    const auto [place, fresh] = views_.try_emplace(index, 0);
    if (!fresh) return place->second;
    const auto bytes = view_bytes(doc_, "buffer view " + std::to_string(index), index);
    spend(bytes.size());
    return place->second = glb_.add_view(bytes);
  }

 private:
  // Views and accessors may overlap, and each is written out in full.
  void spend(size_t bytes) {
    left_ -= std::min(left_, bytes);
    if (left_ == 0) doc_.fail("", "its buffer views and accessors name the same bytes many times over");
  }

  static bool is_scalar_float(const Elements& elements) {
    return elements.type == TINYGLTF_TYPE_SCALAR && elements.component_type == TINYGLTF_COMPONENT_TYPE_FLOAT;
  }

  // The keys as `repair` has them; empty where that is how they are.
  const std::vector<size_t>& mended_keys(int input) {
    const auto [place, fresh] = mended_.try_emplace(input);
    std::vector<size_t>& keys = place->second;
    if (!fresh || !is_scalar_float(read_elements(doc_, input))) return keys;
    const Rows time = read_rows(doc_, input, Legal::Float, {TINYGLTF_TYPE_SCALAR});
    if (!time.allFinite()) return keys;
    keys = keys_in_order({time.data(), size_t(time.rows())});
    const bool as_they_are =
        Eigen::Index(keys.size()) == time.rows() && std::is_sorted(keys.begin(), keys.end());
    if (as_they_are) keys.clear();
    return keys;
  }

  // What the document says of an accessor, but for where its bytes are.
  Json entry_of(int index) const {
    Json entry = doc_.json["accessors"][size_t(index)];
    for (const char* key : {"bufferView", "byteOffset", "sparse"}) entry.erase(key);
    return entry;
  }

  // Moves over some of the keys that the accessor holds, as many as `input` has times. A key may be several
  // elements.
  int picked(int index, int input, const std::vector<size_t>& keys) {
    const auto [place, fresh] = picked_.try_emplace({index, input}, 0);
    if (!fresh) return place->second;
    const Elements elements = read_elements(doc_, index);
    const size_t per_key = elements.count / read_elements(doc_, input).count;
    const size_t size = per_key * elements.size;
    std::vector<unsigned char> bytes;
    for (const size_t key : keys) {
      const auto first = elements.bytes.begin() + std::ptrdiff_t(key * size);
      bytes.insert(bytes.end(), first, first + std::ptrdiff_t(size));
    }
    Json entry = entry_of(index);
    for (const char* bound : {"min", "max"}) entry.erase(bound);
    if (index == input) {
      const Rows time = read_rows(doc_, input, Legal::Float, {TINYGLTF_TYPE_SCALAR});
      entry["min"] = {time.minCoeff()}, entry["max"] = {time.maxCoeff()};
    }
    entry["count"] = per_key * keys.size();
    return place->second = glb_.add_elements(std::move(entry), bytes, elements.size, Use::Plain);
  }

  const GltfDocument& doc_;
  GltfBuilder& glb_;
  size_t left_ = 64 * doc_.most_elements();  // bytes
  std::map<int, int> accessors_, views_;
  std::map<int, std::vector<size_t>> mended_;  // by accessor of times
  std::map<std::pair<int, int>, int> picked_;  // by accessor and accessor of times
};

bool is_in(const Json& list, const Json& index) {
  return index.is_number_unsigned() && index.get<std::uint64_t>() < list.size();
}

// An extension that is not known can only be followed by the names the specification gives to such members.
void move_references(const Json& source, Json& value, bool in_extension, Mover& mover) {
  const Json &views = member(source, "bufferViews"), &accessors = member(source, "accessors");
  if (value.is_array()) {
    for (Json& item : value) move_references(source, item, in_extension, mover);
  }
  if (!value.is_object()) return;
  for (auto& [key, item] : value.items()) {
    if (in_extension && key == "bufferView" && is_in(views, item)) {
      item = mover.view(item.get<int>());
    } else if (in_extension && key == "accessor" && is_in(accessors, item)) {
      item = mover.accessor(item.get<int>());
    } else if (in_extension && key == "attributes" && item.is_object()) {
      for (auto& [name, accessor] : item.items()) {
        if (is_in(accessors, accessor)) accessor = mover.accessor(accessor.get<int>());
      }
    } else if (key != "extras") {
      move_references(source, item, in_extension || key == "extensions", mover);
    }
  }
}

std::string_view mime_type(const std::vector<unsigned char>& image) {
  const std::string_view bytes(reinterpret_cast<const char*>(image.data()), image.size());
  if (bytes.starts_with("\x89PNG")) return "image/png";
  if (bytes.starts_with("\xFF\xD8\xFF")) return "image/jpeg";
  if (bytes.starts_with("RIFF") && bytes.substr(8).starts_with("WEBP")) return "image/webp";
  if (bytes.starts_with("\xABKTX 20")) return "image/ktx2";
  return {};
}

// A GLB is often written to another folder than its source's: it takes its images along where it can.
void move_images(const GltfDocument& doc, GltfBuilder& glb, Mover& mover) {
  if (!glb.json.contains("images")) return;
  std::map<const void*, int> views;  // of images that are the same bytes
  for (size_t i = 0; i < glb.json["images"].size(); ++i) {
    Json& image = glb.json["images"][i];
    if (image.contains("bufferView")) {
      image["bufferView"] = mover.view(image["bufferView"].get<int>());
    } else if (doc.images[i] && (image.contains("mimeType") || !mime_type(*doc.images[i]).empty())) {
      const auto [view, fresh] = views.try_emplace(doc.images[i].get(), 0);
      if (fresh) view->second = glb.add_view(*doc.images[i]);
      image.erase("uri");
      if (!mime_type(*doc.images[i]).empty()) image["mimeType"] = mime_type(*doc.images[i]);
      image["bufferView"] = view->second;
    }
  }
}

bool moves_lost_morphs(const Json& channel, const std::vector<bool>& has_morphs) {
  const Json& target = member(channel, "target");
  if (member(target, "path") != "weights" || member(target, "node").is_null()) return false;
  const size_t node = target["node"].get<size_t>();
  return node >= has_morphs.size() || !has_morphs[node];
}

// Leaves out the channels whose morphs are gone, then the samplers that no channel plays.
Json moved_animation(Json animation, const std::vector<bool>& has_morphs, Mover& mover) {
  Json channels = Json::array(), samplers = Json::array();
  std::map<size_t, size_t> kept;  // sampler
  for (Json& channel : animation["channels"]) {
    if (moves_lost_morphs(channel, has_morphs)) continue;
    const size_t sampler = channel["sampler"].get<size_t>();
    const auto [place, fresh] = kept.try_emplace(sampler, samplers.size());
    if (fresh) {
      Json& copy = samplers.emplace_back(animation["samplers"][sampler]);
      mover.sampler(copy);
    }
    channel["sampler"] = place->second;
    channels.push_back(std::move(channel));
  }
  animation["channels"] = std::move(channels);
  animation["samplers"] = std::move(samplers);
  return animation;
}

// Sets a list that must not be empty, or takes it away.
void set_list(Json& json, const char* name, Json list) {
  if (list.empty()) {
    json.erase(name);
  } else {
    json[name] = std::move(list);
  }
}

void drop_packing(Json& json, const char* list) {
  Json kept = Json::array();
  for (const Json& name : member(json, list)) {
    if (std::find(std::begin(kPacking), std::end(kPacking), name) == std::end(kPacking)) kept.push_back(name);
  }
  set_list(json, list, std::move(kept));
}

}  // namespace

void keep_document(const GltfDocument& doc, const std::vector<bool>& has_morphs, GltfBuilder& glb) {
  Json& json = glb.json = doc.json;
  for (const char* key : {"accessors", "bufferViews", "buffers", "meshes", "skins"}) json.erase(key);
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) drop_packing(json, list);
  for (Json& node : json["nodes"]) {
    for (const char* key : {"mesh", "skin"}) node.erase(key);
  }
  Mover mover(doc, glb);
  move_references(doc.json, json, false, mover);
  move_images(doc, glb, mover);
  Json animations = Json::array();
  for (const Json& animation : member(json, "animations")) {
    Json moved = moved_animation(animation, has_morphs, mover);
    if (!moved["channels"].empty()) animations.push_back(std::move(moved));
  }
  set_list(json, "animations", std::move(animations));
}

}  // namespace skinlod
