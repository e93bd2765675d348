// SPDX-License-Identifier: MIT
#include "formats/images.h"

#include <algorithm>
#include <filesystem>

#include "formats/file.h"
#include "formats/gltf_accessor.h"

namespace skinlod {
namespace {

using Image = std::vector<unsigned char>;

Image gltf_image(const GltfDocument& doc, size_t material) {
  const auto item = [&](const char* list, const Json& index) -> const Json& {
    static const Json none;
    const Json& items = member(doc.json, list);
    return index.is_number() && index.get<size_t>() < items.size() ? items[index.get<size_t>()] : none;
  };
  const Json& look = member(item("materials", material), "pbrMetallicRoughness");
  const Json& index = member(item("textures", member(member(look, "baseColorTexture"), "index")), "source");
  const Json& view = member(item("images", index), "bufferView");
  if (!view.is_null()) {
    const auto bytes = view_bytes(doc, "image", view.get<int>());
    return {bytes.begin(), bytes.end()};
  }
  return index.is_null() ? Image{} : doc.images.at(index.get<size_t>()).value_or(Image{});
}

Image image_beside(const std::string& path, std::string name) {
  std::ranges::replace(name, '\\', '/');
  const auto folder = std::filesystem::path(path).parent_path();
  for (const auto& file : {folder / name, folder / std::filesystem::path(name).filename()}) {
    if (name.empty() || !std::filesystem::is_regular_file(file)) continue;
    const auto bytes = read_file(file.string());
    const auto* begin = reinterpret_cast<const unsigned char*>(bytes.data());
    return {begin, begin + bytes.size()};
  }
  return {};
}

}  // namespace

std::vector<std::vector<unsigned char>> base_colour_images(const Imported& imported,
                                                           const std::string& path) {
  std::vector<Image> images;
  for (size_t m = 0; m < imported.character.materials.size(); ++m) {
    images.push_back(imported.document ? gltf_image(*imported.document, m)
                                       : image_beside(path, imported.character.materials[m].texture));
  }
  return images;
}

}  // namespace skinlod
