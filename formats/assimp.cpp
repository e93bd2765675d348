// SPDX-License-Identifier: MIT
#include "formats/assimp.h"

#include <assimp/cimport.h>
#include <assimp/config.h>

#include <assimp/ColladaMetaData.h>
#include <assimp/DefaultIOSystem.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <filesystem>
#include <new>
#include <set>

#include "formats/archive.h"
#include "formats/assimp_scene.h"
#include "formats/file.h"
#include "formats/isolate.h"
#include "pipeline/error.h"

namespace skinlod {
namespace {

/// Lets Assimp read regular files, write none, and tells which it opened.
class ReadOnlyFiles : public Assimp::DefaultIOSystem {
 public:
  explicit ReadOnlyFiles(std::vector<std::string>& opened) : opened_(opened) {}

  Assimp::IOStream* Open(const char* file, const char* mode) override {
    std::error_code error;
    if (std::string(mode).find_first_of("wa+") != std::string::npos) return nullptr;
    if (!std::filesystem::is_regular_file(file, error)) return nullptr;
    Assimp::IOStream* stream = DefaultIOSystem::Open(file, mode);
    if (stream && std::find(opened_.begin(), opened_.end(), file) == opened_.end()) opened_.push_back(file);
    return stream;
  }
  bool CreateDirectory(const std::string&) override { return false; }
  bool DeleteFile(const std::string&) override { return false; }

 private:
  std::vector<std::string>& opened_;
};

/// Whether every node of a Collada file has a name of its own. Beside names, which are what the author gave,
/// its nodes have ids, which exporters make of them and of the object's; Assimp binds by either.
bool has_unique_names(const aiNode& node, std::set<std::string>& names) {
  if (node.mMetaData && node.mMetaData->HasKey(AI_METADATA_COLLADA_ID)) {
    const std::string name = node.mName.C_Str();
    if (name.starts_with("$ColladaAutoName$") || !names.insert(name).second) return false;
  }
  return std::all_of(node.mChildren, node.mChildren + node.mNumChildren,
                     [&](const aiNode* child) { return has_unique_names(*child, names); });
}

const aiScene* read_with(Assimp::Importer& importer, const std::string& path) {
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);
  const aiScene* scene = importer.ReadFile(path, 0);
  std::set<std::string> names;
  if (!scene || !scene->mRootNode || has_unique_names(*scene->mRootNode, names)) return scene;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, false);
  return importer.ReadFile(path, 0);
}

Imported import_here(const std::string& path, Need need) {
  std::vector<std::string> opened;
  Assimp::Importer importer;
  importer.SetIOHandler(new ReadOnlyFiles(opened));  // the importer owns it
  // Kept as nodes, pivots tear apart what a clip from another file moves.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  // A skeleton without a mesh would come back as a mesh of little bones.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const aiScene* scene = read_with(importer, path);
  if (!scene || !scene->mRootNode) {
    std::string reason = importer.GetErrorString();
    reason = reason.substr(0, std::min<size_t>(reason.find('\n'), 160));  // some quote the rest of the file
    if (reason.find("bad_alloc") != std::string::npos) throw std::bad_alloc();
    throw Error(Fault::Input,
                path + ": cannot be read: " + reason +
                    ": the file is damaged or not what its name says: export it again, or as glTF");
  }
  Imported imported = read_scene(*scene, path, need);
  imported.files_read = std::move(opened);
  return imported;
}

/// Far more than any sound file needs, so that a machine under load does not fail it.
Limits limits_for(size_t file_size) {
  const int mebibytes = int(file_size >> 20);
  Limits limits;
  limits.cpu_seconds = 60 + 10 * mebibytes;
  limits.wall_seconds = 10 * limits.cpu_seconds;
  limits.memory_bytes = (std::uint64_t(1) << 30) + 64 * std::uint64_t(file_size);
  return limits;
}

}  // namespace

Imported import_assimp(const std::string& path, Need need) {
  const size_t size = read_file(path).size();  // tells what keeps a file from being read better than Assimp
  if (size == 0) throw Error(Fault::Input, path + ": is empty: export it again");
  return from_bytes(run_isolated(path, limits_for(size), [&] { return to_bytes(import_here(path, need)); }));
}

bool assimp_reads(const std::string& extension) {
  return aiIsExtensionSupported(("." + extension).c_str()) == AI_TRUE;
}

}  // namespace skinlod
