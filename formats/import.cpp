// SPDX-License-Identifier: MIT
#include "formats/import.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>

#include "formats/assimp.h"
#include "formats/file.h"
#include "formats/gltf.h"
#include "formats/import_any.h"
#include "pipeline/error.h"

namespace skinlod {
namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

bool ends_with_format(const std::string& path, const Format& format) {
  return std::any_of(format.extensions.begin(), format.extensions.end(),
                     [&](const std::string& extension) { return lower(path).ends_with("." + extension); });
}

/// glTF is told by its content: it comes under many names (.vrm, .glb, .gltf), and Assimp may not have it.
bool is_gltf(std::string_view content) {
  if (content.starts_with("glTF")) return true;
  if (content.starts_with("\xEF\xBB\xBF")) content.remove_prefix(3);
  const size_t first = content.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && content[first] == '{' &&
         content.find("\"asset\"") != std::string_view::npos;
}

std::string readable_formats() {
  std::string list;
  for (const Format& format : formats()) {
    for (const std::string& extension : format.extensions) {
      if (format.reads) list += (list.empty() ? "." : ", .") + extension;
    }
  }
  return list;
}

}  // namespace

std::string stem(const std::string& path) {
  const std::filesystem::path name = std::filesystem::path(path).filename().stem();
  return (lower(name.extension().string()) == ".mesh" ? name.stem() : name).string();
}

Imported import_any(const std::string& path, Need need) {
  if (path == "-") {
    throw Error(Fault::Usage,
                "-: a character cannot be read from standard input, as it may name other files: "
                "give its path");
  }
  const std::vector<std::byte> bytes = read_file(path);
  const std::string_view content(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::vector<Format> known = formats();
  const auto named = std::find_if(known.begin(), known.end(),
                                  [&](const Format& format) { return ends_with_format(path, format); });
  const bool is_known = named != known.end();

  const std::string extension = path.substr(path.rfind('.') + 1);

  Imported imported;
  if (is_gltf(content) || (is_known && named->name.starts_with("glTF"))) {
    imported = import_gltf(path, need);
  } else if (is_known && !named->reads) {
    throw Error(Fault::Input, path + ": is cooked already: give the file it was cooked from");
  } else if (is_known || assimp_reads(lower(extension))) {
    imported = import_assimp(path, need);
  } else {
    throw Error(Fault::Input, path + ": its format is not known: these are read: " + readable_formats());
  }
  if (imported.character.name.empty()) imported.character.name = stem(path);
  return imported;
}

Imported import_character(const std::string& path) { return import_any(path, Need::Character); }

std::vector<Format> formats() {
  return {
      {"skinlod", {"slod"}, false, true},
      {"glTF 2.0 binary", {"glb", "vrm"}, true, true},
      {"glTF 2.0", {"gltf"}, true, false},
      {"FBX binary and ASCII", {"fbx"}, true, false},
      {"Collada", {"dae"}, true, false},
      {"DirectX X", {"x"}, true, false},
      {"Blitz3D", {"b3d"}, true, false},
      {"MD5", {"md5mesh", "md5anim"}, true, false},
      {"Ogre binary and XML", {"mesh", "mesh.xml"}, true, false},
  };
}

}  // namespace skinlod
