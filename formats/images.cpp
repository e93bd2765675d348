// SPDX-License-Identifier: MIT
#include "formats/images.h"

#include <algorithm>
#include <filesystem>

#include "formats/file.h"
#include "formats/gltf_accessor.h"
#include "formats/gltf_read.h"

namespace skinlod {
namespace {

using Image = std::vector<unsigned char>;

Image gltf_image(const GltfDocument& doc, size_t material) {
  const auto index = base_colour_image(doc, material);
  if (!index) return {};
  const auto bytes = image_bytes(doc, *index);
  return {bytes.begin(), bytes.end()};
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
