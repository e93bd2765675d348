// SPDX-License-Identifier: MIT
#include "formats/gltf_document.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>

#include "formats/file.h"
#include "pipeline/error.h"

namespace skinlod {
namespace {

constexpr int kDeepestNesting = 200;  // tinygltf and the JSON library recurse
constexpr size_t kMostItems = size_t(1)
                              << 16;  // of a section: two bytes of JSON take tinygltf half a kilobyte
constexpr const char* kSections[] = {"accessors", "animations", "bufferViews", "buffers", "cameras",
                                     "images",    "materials",  "meshes",      "nodes",   "samplers",
                                     "scenes",    "skins",      "textures"};

// The two chunks of a GLB; of a .gltf the text alone.
struct Container {
  std::string_view text;
  std::optional<std::span<const std::byte>> binary;
};

std::uint32_t little_endian(std::span<const std::byte> bytes, size_t at) {
  std::uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value |= std::uint32_t(bytes[at + i]) << 8 * i;
  return value;
}

std::string_view text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Container open_container(const GltfDocument& doc, std::span<const std::byte> bytes) {
  if (bytes.empty()) doc.fail("", "is empty", "export it again");
  if (!text(bytes).starts_with("glTF")) return {text(bytes), {}};
  constexpr std::uint32_t kJson = 0x4E4F534A, kBinary = 0x004E4942;
  if (bytes.size() < 20) doc.fail("", "the file ends inside its header", "copy or export it again");
  if (const std::uint32_t version = little_endian(bytes, 4); version != 2) {
    doc.fail("", "is glTF binary version " + std::to_string(version) + ", not 2", "convert it to glTF 2.0");
  }
  const size_t length = little_endian(bytes, 8);
  if (length > bytes.size() || length < 20) {
    doc.fail("",
             "the file has " + std::to_string(bytes.size()) + " of the " + std::to_string(length) +
                 " bytes its header promises",
             "copy or export it again");
  }
  const auto chunk = [&](size_t at) {
    const size_t size = little_endian(bytes, at);
    if (size > length - at - 8)
      doc.fail("", "a chunk runs past the end of the file", "copy or export it again");
    return bytes.subspan(at + 8, size);
  };
  const std::span json = chunk(12);
  if (little_endian(bytes, 16) != kJson) doc.fail("", "its first chunk is not JSON");
  Container glb{text(json), {}};
  const size_t next = 20 + (json.size() + 3) / 4 * 4;
  if (next + 8 <= length && little_endian(bytes, next + 4) == kBinary) glb.binary = chunk(next);
  return glb;
}

// Looked at beforehand: the parser itself has no limit, and with a callback it takes quadratic time.
int deepest_nesting(std::string_view text) {
  int depth = 0, deepest = 0;
  bool is_quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (is_quoted && c == '\\') {
      ++i;
    } else if (c == '"') {
      is_quoted = !is_quoted;
    } else if (!is_quoted) {
      depth += int(c == '[' || c == '{') - int(c == ']' || c == '}');
      deepest = std::max(deepest, depth);
    }
  }
  return deepest;
}

Json parse(const GltfDocument& doc, std::string_view text) {
  if (deepest_nesting(text) > kDeepestNesting) doc.fail("", "its JSON is nested too deeply");
  try {
    return Json::parse(text);
  } catch (const Json::exception& e) {
    doc.fail("", "is not valid JSON (" + std::string(e.what()) + ")");
  }
}

enum class Kind { Index, Size, Indices, Numbers, Text, Name, Flag };

struct Rule {
  const char* objects;  // where, through lists: "meshes/primitives"
  const char* members;  // by name; "*" is every one
  Kind kind;
};

// tinygltf takes a member of the wrong type for one that is absent, skips a primitive it cannot read and cuts
// large integers off: a lie must not become another, valid index. Every object on these paths is there in
// `model` too, and is an object.
constexpr Rule kRules[] = {
    {"", "scene", Kind::Index},
    {"asset", "minVersion version", Kind::Text},
    {"accessors", "bufferView componentType", Kind::Index},
    {"accessors", "byteOffset count", Kind::Size},
    {"accessors", "normalized", Kind::Flag},
    {"accessors/sparse", "count", Kind::Index},
    {"accessors/sparse/indices", "bufferView byteOffset componentType", Kind::Index},
    {"accessors/sparse/values", "bufferView byteOffset", Kind::Index},
    {"animations", "name", Kind::Name},
    {"animations/channels", "sampler", Kind::Index},
    {"animations/channels/target", "node", Kind::Index},
    {"animations/channels/target", "path", Kind::Text},
    {"animations/samplers", "input output", Kind::Index},
    {"animations/samplers", "interpolation", Kind::Text},
    {"bufferViews", "buffer", Kind::Index},
    {"bufferViews", "byteLength byteOffset byteStride", Kind::Size},
    {"buffers", "byteLength", Kind::Size},
    {"buffers", "uri", Kind::Text},
    {"cameras", "", Kind::Text},
    {"images", "bufferView", Kind::Index},
    {"images", "mimeType uri", Kind::Text},
    {"materials", "doubleSided", Kind::Flag},
    {"materials", "name", Kind::Name},
    {"materials/pbrMetallicRoughness", "baseColorFactor", Kind::Numbers},
    {"materials/pbrMetallicRoughness/baseColorTexture", "index", Kind::Index},
    {"meshes", "name", Kind::Name},
    {"meshes", "weights", Kind::Numbers},
    {"meshes/primitives", "indices material mode", Kind::Index},
    {"meshes/primitives/attributes", "*", Kind::Index},
    {"meshes/primitives/targets", "*", Kind::Index},
    {"nodes", "camera mesh skin", Kind::Index},
    {"nodes", "children", Kind::Indices},
    {"nodes", "matrix rotation scale translation weights", Kind::Numbers},
    {"nodes", "name", Kind::Name},
    {"scenes", "nodes", Kind::Indices},
    {"skins", "inverseBindMatrices skeleton", Kind::Index},
    {"skins", "joints", Kind::Indices},
    {"textures", "sampler source", Kind::Index},
};

bool is_kind(const Json& value, Kind kind) {
  const auto is_index = [](const Json& v) {
    return v.is_number_unsigned() && v.get<std::uint64_t>() <= std::uint64_t(std::numeric_limits<int>::max());
  };
  const auto is_number = [](const Json& v) { return v.is_number(); };
  switch (kind) {
    case Kind::Index:
      return is_index(value);
    case Kind::Size:
      return value.is_number_unsigned();
    case Kind::Indices:
      return value.is_array() && std::all_of(value.begin(), value.end(), is_index);
    case Kind::Numbers:
      return value.is_array() && std::all_of(value.begin(), value.end(), is_number);
    case Kind::Text:
    case Kind::Name:
      return value.is_string();
    case Kind::Flag:
      return value.is_boolean();
  }
  return false;
}

// Checks `rule` on the objects that `path` leads to from `value`, which stands at `where`.
void check(const GltfDocument& doc, const Rule& rule, std::string_view path, const Json& value,
           const std::string& where) {
  if (value.is_null()) return;
  if (value.is_array()) {
    for (size_t i = 0; i < value.size(); ++i) {
      const std::string item = where + "[" + std::to_string(i) + "]";
      if (value[i].is_null()) doc.fail(item, "is no object");
      check(doc, rule, path, value[i], item);
    }
    return;
  }
  if (!value.is_object()) doc.fail(where, "is no object");
  if (!path.empty()) {
    const std::string key(path.substr(0, path.find('/')));
    check(doc, rule, path.substr(std::min(path.size(), key.size() + 1)), member(value, key),
          where.empty() ? key : where + "." + key);
    return;
  }
  for (const auto& [key, v] : value.items()) {
    const bool meant = rule.members == std::string_view("*") ||
                       (" " + std::string(rule.members) + " ").find(" " + key + " ") != std::string::npos;
    if (!meant) continue;
    if (!is_kind(v, rule.kind)) doc.fail(where, "\"" + key + "\" has a value of the wrong type");
    if (rule.kind == Kind::Name) doc.check_name(where, v.get_ref<const std::string&>());
  }
}

// Every clip brings some hundred accessors.
bool may_be_long(std::string_view section) { return section == "accessors" || section == "bufferViews"; }

void check_types(const GltfDocument& doc) {
  for (const char* section : kSections) {
    if (const Json& list = member(doc.json, section); !list.is_null() && !list.is_array()) {
      doc.fail(section, "is no list");
    } else if (list.size() > kMostItems && !may_be_long(section)) {
      doc.fail(section, "has " + std::to_string(list.size()) + " items, more than 65536");
    }
  }
  for (const Rule& rule : kRules) check(doc, rule, rule.objects, doc.json, "");
}

// Extensions change what a file means; these leave the shape and the motion of a character alone.
void check_extensions(const GltfDocument& doc) {
  static constexpr std::string_view harmless[] = {"KHR_materials_", "KHR_texture_",         "EXT_texture_",
                                                  "MSFT_texture_",  "KHR_lights_punctual",  "EXT_lights_",
                                                  "KHR_xmp",        "KHR_mesh_quantization"};
  for (const Json& item : member(doc.json, "extensionsRequired")) {
    const std::string extension = item.is_string() ? item.get<std::string>() : item.dump();
    const bool known = std::any_of(std::begin(harmless), std::end(harmless),
                                   [&](std::string_view prefix) { return extension.starts_with(prefix); });
    if (known) continue;
    const bool packed = extension == "KHR_draco_mesh_compression" || extension == "EXT_meshopt_compression" ||
                        extension == "KHR_meshopt_compression";
    doc.fail("", "requires the extension " + extension + ", which is not supported",
             packed ? "export it uncompressed, or decompress it with another tool first"
                    : "export it without this extension");
  }
}

std::string percent_decoded(const std::string& uri) {
  const auto digit = [](char c) {
    return c >= '0' && c <= '9' ? c - '0' : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10 : -1;
  };
  std::string out;
  for (size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      out += char(digit(uri[i + 1]) * 16 + digit(uri[i + 2]));
      i += 2;
    } else {
      out += uri[i];
    }
  }
  return out;
}

std::vector<unsigned char> to_chars(std::span<const std::byte> bytes) {
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  return {data, data + bytes.size()};
}

// What the URIs of a document stand for: data in base64, or files beside it. Each is read once: a few lines
// can name one large file a thousand times.
class Resources {
 public:
  explicit Resources(GltfDocument& doc) : doc_(doc) {}

  // Null where the URI is neither.
  SharedBytes at(const std::string& uri) {
    const auto [place, fresh] = known_.try_emplace(uri);
    if (fresh) place->second = uri.starts_with("data:") ? decoded(uri) : file(uri);
    return place->second;
  }

 private:
  static SharedBytes decoded(const std::string& uri) {
    const size_t data = uri.find(";base64,");
    if (data == std::string::npos) return {};
    std::vector<unsigned char> out;
    std::string type;
    const std::string plain = "data:application/octet-stream" + uri.substr(data);
    if (!tinygltf::DecodeDataURI(&out, type, plain, 0, false)) return {};
    return std::make_shared<const std::vector<unsigned char>>(std::move(out));
  }

  SharedBytes file(const std::string& uri) {
    const std::filesystem::path relative = percent_decoded(uri);
    if (uri.empty() || relative.is_absolute() || uri.find("://") != std::string::npos) return {};
    const std::string path =
        (std::filesystem::path(doc_.path).parent_path() / relative).lexically_normal().string();
    const auto [place, fresh] = files_.try_emplace(path);
    if (!fresh) return place->second;
    std::error_code unknown;
    const auto kind = std::filesystem::status(path, unknown).type();
    if (kind != std::filesystem::file_type::regular && kind != std::filesystem::file_type::not_found)
      return {};
    place->second = std::make_shared<const std::vector<unsigned char>>(to_chars(read_file(path)));
    doc_.files_read.push_back(path);
    return place->second;
  }

  GltfDocument& doc_;
  std::map<std::string, SharedBytes> known_, files_;  // by URI, by path
};

void read_buffers(GltfDocument& doc, Resources& resources, std::optional<std::span<const std::byte>> binary) {
  const Json& buffers = member(doc.json, "buffers");
  for (size_t i = 0; i < buffers.size(); ++i) {
    const std::string part = "buffer " + std::to_string(i);
    SharedBytes& buffer = doc.buffers.emplace_back();
    if (const Json& uri = member(buffers[i], "uri"); uri.is_string()) {
      buffer = resources.at(uri.get<std::string>());
      if (!buffer) doc.fail(part, "its uri is neither base64 data nor a file beside it");
    } else if (i == 0 && binary) {
      buffer = std::make_shared<const std::vector<unsigned char>>(to_chars(*binary));
    } else {
      continue;  // a place holder that an extension fills; an error once something reads it
    }
    const std::uint64_t promised = buffers[i].value("byteLength", std::uint64_t(0));
    if (buffer->size() < promised) {
      doc.fail(
          part,
          "has " + std::to_string(buffer->size()) + " of the " + std::to_string(promised) + " bytes promised",
          "copy or export it again");
    }
  }
}

// Textures do not bear on the cook: one that is missing stays the URI that it is.
void read_images(GltfDocument& doc, Resources& resources) {
  for (const Json& image : member(doc.json, "images")) {
    auto& bytes = doc.images.emplace_back();
    const Json& uri = member(image, "uri");
    try {
      if (uri.is_string()) bytes = resources.at(uri.get<std::string>());
    } catch (const Error&) {
    }
  }
}

Json without_extensions(Json value) {
  if (value.is_object()) value.erase("extensions"), value.erase("extras");
  if (value.is_structured()) {
    for (Json& item : value) item = without_extensions(std::move(item));
  }
  return value;
}

void read_model(GltfDocument& doc) {
  Json view;
  for (const char* key : {"accessors", "animations", "asset", "bufferViews", "materials", "meshes", "nodes",
                          "scene", "scenes", "skins"}) {
    if (const Json& section = member(doc.json, key); !section.is_null()) {
      view[key] = without_extensions(section);
    }
  }
  // Channels that an extension aims elsewhere have no node, and tinygltf would skip them.
  for (Json& animation : view["animations"]) {
    for (Json& channel : animation["channels"]) {
      if (channel.contains("target") && !channel["target"].contains("node")) channel["target"]["node"] = -1;
    }
  }
  const std::string text = view.dump();
  if (text.size() > std::numeric_limits<unsigned>::max()) doc.fail("", "its JSON has more than 4 GB");
  std::string error, warning;
  tinygltf::TinyGLTF reader;
  if (!reader.LoadASCIIFromString(&doc.model, &error, &warning, text.data(), unsigned(text.size()), "")) {
    error = error.substr(0, error.find('\n'));
    doc.fail("", "is not valid glTF (" + error + ")");
  }
}

// tinygltf leaves out what it cannot read, and goes on.
void check_nothing_skipped(const GltfDocument& doc) {
  for (size_t m = 0; m < doc.model.meshes.size(); ++m) {
    if (doc.model.meshes[m].primitives.size() != member(doc.json["meshes"][m], "primitives").size()) {
      doc.fail("mesh " + std::to_string(m), "has a primitive without attributes");
    }
  }
  for (size_t a = 0; a < doc.model.animations.size(); ++a) {
    if (doc.model.animations[a].channels.size() != member(doc.json["animations"][a], "channels").size()) {
      doc.fail("animation " + std::to_string(a), "has a channel without sampler, target or path");
    }
  }
}

}  // namespace

const Json& member(const Json& object, const std::string& key) {
  static const Json null;
  if (!object.is_object()) return null;
  const auto found = object.find(key);
  return found == object.end() ? null : *found;
}

void GltfDocument::fail(const std::string& part, const std::string& fact, const std::string& remedy) const {
  throw Error{Fault::Input, path + ": " + (part.empty() ? "" : part + ": ") + fact + ": " + remedy};
}

void GltfDocument::check_name(const std::string& part, const std::string& name) const {
  constexpr size_t kLongest = 1024;
  if (name.size() > kLongest)
    fail(part, "has a name of " + std::to_string(name.size()) + " bytes", "give it one of at most 1024");
}

size_t GltfDocument::most_elements() const {
  size_t bytes = 0;
  std::set<const void*> counted;
  for (const SharedBytes& buffer : buffers) {
    if (buffer && counted.insert(buffer.get()).second) bytes += buffer->size();
  }
  return bytes + (size_t(1) << 18);
}

GltfDocument read_document(const std::string& path) {
  GltfDocument doc{.path = path, .json = {}, .model = {}, .buffers = {}, .images = {}, .files_read = {path}};
  const std::vector<std::byte> bytes = read_file(path);
  const Container container = open_container(doc, bytes);
  doc.json = parse(doc, container.text);
  if (!doc.json.is_object()) doc.fail("", "is not a glTF file", "give a .glb or .gltf file");
  check_types(doc);
  const std::string version =
      member(doc.json, "asset").is_object() ? doc.json["asset"].value("version", "") : "";
  if (!version.starts_with("2.")) {
    doc.fail("", version.empty() ? "names no glTF version" : "is glTF " + version + ", not 2.0",
             "convert it to glTF 2.0");
  }
  if (const Json& least = member(doc.json["asset"], "minVersion"); !least.is_null() && least != "2.0") {
    doc.fail("", "needs a reader of glTF " + least.get<std::string>() + ", and this one knows 2.0",
             "export it as glTF 2.0");
  }
  check_extensions(doc);
  Resources resources(doc);
  read_buffers(doc, resources, container.binary);
  read_images(doc, resources);
  read_model(doc);
  check_nothing_skipped(doc);
  return doc;
}

}  // namespace skinlod
