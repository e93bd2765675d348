// SPDX-License-Identifier: MIT
#include <filesystem>

#include "formats/gltf.h"
#include "formats/gltf_accessor.h"
#include "formats/gltf_read.h"

namespace skinlod {
namespace {

void warn_of_cameras_and_lights(const GltfDocument& doc, Warnings& warnings) {
  std::int64_t count = 0;
  for (const Json& node : member(doc.json, "nodes")) {
    const bool has_light = !member(member(node, "extensions"), "KHR_lights_punctual").is_null();
    count += int(!member(node, "camera").is_null()) + int(has_light);
  }
  warn(warnings, {WarningCode::NotASkinFeature, "", count, "cameras or lights, kept in glTF only"});
}

// Nothing looks into images, but what is written out must be there.
void check_images(const GltfDocument& doc) {
  const Json& images = member(doc.json, "images");
  for (size_t i = 0; i < images.size(); ++i) {
    if (const Json& view = member(images[i], "bufferView"); !view.is_null()) {
      view_bytes(doc, numbered("image", i), view.get<int>());
    }
  }
}

}  // namespace

Imported import_gltf(const std::string& path, Need need) {
  const auto doc = std::make_shared<GltfDocument>(read_document(path));
  Imported imported;
  Character& character = imported.character;
  character.name = std::filesystem::path(path).stem().string();
  character.skeleton = read_nodes(*doc, imported.warnings);
  if (need == Need::Character) {
    drop_repeated_roots(*doc, imported.warnings);
    character.materials = read_materials(*doc);
    read_surface(*doc, character, imported.warnings);
    check_images(*doc);
    warn_of_cameras_and_lights(*doc, imported.warnings);
  }
  character.clips = read_clips(*doc, imported.warnings);
  imported.files_read = doc->files_read;
  imported.document = doc;
  return imported;
}

}  // namespace skinlod
