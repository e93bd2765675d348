// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/gltf.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <tiny_gltf.h>
#pragma GCC diagnostic pop

namespace skinlod {

using Json = nlohmann::json;

/// The bytes of a file or of a data URI: one copy, however often the document names it.
using SharedBytes = std::shared_ptr<const std::vector<unsigned char>>;

/// A glTF file in two readings of the same text: `json` is all of it, so that what we do not know survives;
/// `model` is the part that makes a character, as tinygltf types it, without extras and extensions.
/// Where `model` has an object, `json` has it at the same index, and it is an object.
struct GltfDocument {
  std::string path;
  Json json;
  tinygltf::Model model;
  std::vector<SharedBytes> buffers;  // null for a place holder that an extension would fill
  std::vector<SharedBytes> images;   // encoded; null where it cannot be read
  std::vector<std::string> files_read;
  std::vector<int> primitives = {};  // per part of the character: its primitive's index in the mesh

  /// Throws Error{Input}: "path: part: fact: remedy".
  [[noreturn]] void fail(const std::string& part, const std::string& fact,
                         const std::string& remedy = "re-export the file") const;

  /// How many vertices, morph offsets or keys the file can mean: as many as its buffers have bytes, and a
  /// quarter of a million in any case. A few lines can name one mesh many times over, or elements that have
  /// no bytes at all; nobody makes a character so.
  size_t most_elements() const;

  /// Throws Error{Input} where a name is so long that a few lines could fill the memory with copies of it.
  void check_name(const std::string& part, const std::string& name) const;
};

/// Reads the file at `path` and the buffers and images it names. Every index and count that our part of it
/// holds is a non-negative integer, every list a list; whether they fit together is not yet known.
GltfDocument read_document(const std::string& path);

/// The member `key` of `object`, or null.
const Json& member(const Json& object, const std::string& key);

}  // namespace skinlod
