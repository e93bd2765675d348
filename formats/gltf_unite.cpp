// SPDX-License-Identifier: MIT
#include "formats/gltf_unite.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <string>

#include "formats/gltf_accessor.h"
#include "formats/gltf_scene.h"

namespace skinlod {
namespace {

int place_in(Json& list, Json item) {
  const auto found = std::find(list.begin(), list.end(), item);
  if (found != list.end()) return int(found - list.begin());
  list.push_back(std::move(item));
  return int(list.size()) - 1;
}

// Puts the new place where `value` is the old one; one that is out of range is left for the reader to see.
void renumber(Json& value, const std::vector<int>& places) {
  if (value.is_number_unsigned() && value.get<std::uint64_t>() < places.size())
    value = places[value.get<size_t>()];
}

// Every texture that a material names stands in a member "...Texture", in extensions too.
void renumber_textures(Json& value, const std::vector<int>& textures) {
  if (!value.is_structured()) return;
  for (auto& [key, item] : value.items()) {
    const bool is_texture = key.ends_with("Texture") || key.ends_with("texture");
    if (value.is_object() && is_texture && item.is_object() && item.contains("index"))
      renumber(item["index"], textures);
    renumber_textures(item, textures);
  }
}

void collect_extensions(const Json& value, std::set<std::string>& names) {
  if (!value.is_structured()) return;
  for (const auto& [key, item] : value.items()) {
    if (value.is_object() && key == "extensions" && item.is_object()) {
      for (const auto& extension : item.items()) names.insert(extension.key());
    }
    collect_extensions(item, names);
  }
}

class Joining {
 public:
  Joining(GltfDocument& whole, const GltfDocument& other) : whole_(whole), other_(other) {}

  std::vector<int> materials() {
    const std::vector<int> samplers = moved("samplers", [](Json&) {});
    const std::vector<int> images = moved_images();
    const std::vector<int> textures = moved("textures", [&](Json& texture) {
      if (texture.contains("sampler")) renumber(texture["sampler"], samplers);
      if (texture.contains("source")) renumber(texture["source"], images);
      if (!texture.contains("extensions")) return;
      for (Json& extension : texture["extensions"]) {
        if (extension.is_object() && extension.contains("source")) renumber(extension["source"], images);
      }
    });
    const std::vector<int> materials =
        moved("materials", [&](Json& material) { renumber_textures(material, textures); });
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
      for (const Json& name : member(other_.json, list)) {
        if (name.is_string() && extensions_.contains(name.get<std::string>()))
          place_in(whole_.json[list], name);
      }
    }
    return materials;
  }

 private:
  std::vector<int> moved(const char* list, const auto& mend) {
    std::vector<int> places;
    for (Json item : member(other_.json, list)) {
      mend(item);
      collect_extensions(item, extensions_);
      places.push_back(place_in(whole_.json[list], std::move(item)));
    }
    return places;
  }

  // Images are the same where their bytes are, however they are named.
  std::vector<int> moved_images() {
    std::vector<int> places;
    for (size_t i = 0; i < member(other_.json, "images").size(); ++i) {
      const auto bytes = image_bytes(other_, i);
      size_t place = 0;
      while (place < whole_.images.size() &&
             (bytes.empty() || !std::ranges::equal(image_bytes(whole_, place), bytes)))
        ++place;
      places.push_back(int(place));
      if (place < whole_.images.size()) continue;
      Json image = other_.json["images"][i];
      image.erase("bufferView");
      whole_.json["images"].push_back(std::move(image));
      whole_.images.push_back(
          bytes.empty() ? nullptr
                        : std::make_shared<const std::vector<unsigned char>>(bytes.begin(), bytes.end()));
    }
    return places;
  }

  GltfDocument& whole_;
  const GltfDocument& other_;
  std::set<std::string> extensions_;  // of what was moved
};

// What only a document says, of the file and of its nodes and meshes.
std::int64_t left_behind(const GltfDocument& doc) {
  std::int64_t count = 0;
  const auto look = [&](const Json& item) {
    count += std::int64_t(member(item, "extensions").size());
    count += !member(item, "camera").is_null();
  };
  look(doc.json);
  for (const char* list : {"nodes", "meshes", "scenes", "skins"}) {
    for (const Json& item : member(doc.json, list)) look(item);
  }
  return count;
}

}  // namespace

std::pair<std::shared_ptr<const GltfDocument>, std::vector<int>> with_materials(const GltfDocument& first,
                                                                                const Imported& other,
                                                                                Warnings& warnings) {
  const auto whole = std::make_shared<GltfDocument>(first);
  std::vector<int> materials;
  if (other.document) {
    materials = Joining(*whole, *other.document).materials();
    warn(warnings, {WarningCode::ExtensionDropped, other.character.name, left_behind(*other.document),
                    "of a file that is not the first"});
  } else {
    const size_t count = whole->json["materials"].size();
    add_materials(other.character, whole->json);
    for (size_t m = 0; m < other.character.materials.size(); ++m) materials.push_back(int(count + m));
    whole->images.resize(member(whole->json, "images").size());
  }
  for (const char* list :
       {"samplers", "images", "textures", "materials", "extensionsUsed", "extensionsRequired"}) {
    if (whole->json.contains(list) && whole->json[list].empty()) whole->json.erase(list);
  }
  return {whole, materials};
}

}  // namespace skinlod
