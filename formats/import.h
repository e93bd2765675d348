// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pipeline/character.h"
#include "pipeline/warning.h"

namespace skinlod {

/// A glTF file as read, kept so that what we do not know of it is written out again. Defined in
/// gltf_document.h.
struct GltfDocument;

struct Imported {
  Character character;  // not yet repaired or welded
  Warnings warnings;
  std::vector<std::string> files_read;             // every file the result depends on, for depfiles
  std::shared_ptr<const GltfDocument> document{};  // only from glTF
};

/// What a reader must find in a file: a skin and faces, or only nodes and clips (geometry is then left out).
enum class Need { Character, ClipsOnly };

/// Reads a rigged character in any format of `formats()`; the format is told by the content, then the name.
/// Throws Error{Access} where the file cannot be read, Error{Input} where it is broken, has no skin or no
/// faces.
Imported import_character(const std::string& path);

/// How many of a clip file's channels found a node of the same name.
struct BoundClips {
  std::vector<Clip> clips;
  int channels = 0;
  int bound = 0;
  Warnings warnings;
  std::vector<std::string> files_read;
};

/// Reads only the clips of a file, in any format, and binds their channels to `skeleton` by node name.
/// Throws Error{Input} where the file has no clip or none of its channels bind.
BoundClips import_clips(const std::string& path, const Skeleton& skeleton);

/// `name`, or where a clip of the character has that the first free one of "name (file)", "name (file 2)"...
std::string free_clip_name(const Character& character, const std::string& name, const std::string& file);

struct Format {
  std::string name;                     // "glTF 2.0 binary"
  std::vector<std::string> extensions;  // "glb"
  bool reads = false;
  bool writes = false;
};

/// Every format that can be read or written, ours and glTF first.
std::vector<Format> formats();

}  // namespace skinlod
