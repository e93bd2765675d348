// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "formats/gltf_document.h"

namespace skinlod {

/// An accessor's elements one after the other, as they stand in the file, with sparse values put in.
struct Elements {
  std::string part;        // "accessor 12", for messages
  int component_type = 0;  // TINYGLTF_COMPONENT_TYPE_...
  int type = 0;            // TINYGLTF_TYPE_...
  bool normalised = false;
  size_t count = 0;
  size_t size = 0;  // bytes of an element
  std::vector<unsigned char> bytes;
};

/// Reads accessor `index` and checks every number in it against the bytes that are there. An accessor without
/// bytes is zeros, 16 MiB of them at most: more is a forgery. Throws Error{Input}.
Elements read_elements(const GltfDocument& doc, int index);

/// The bytes of a buffer view; `part` is who asks, for the message. Throws Error{Input}.
std::span<const unsigned char> view_bytes(const GltfDocument& doc, const std::string& part, int index);

/// An image as the file has it, encoded: in a bufferView, or beside the file. Empty where it cannot be read.
std::span<const unsigned char> image_bytes(const GltfDocument& doc, size_t image);

/// The number of components of a TINYGLTF_TYPE_...
int component_count(int type);

/// What the specification allows at one use of an accessor.
enum class Legal {
  Position,    // vec3: float, or quantised
  Direction,   // vec3, vec4: float, or signed and normalised
  Coordinate,  // vec2: float, or quantised
  Colour,      // vec3, vec4: float, or unsigned and normalised
  Weights,     // vec4: float, or unsigned and normalised
  Joints,      // vec4: unsigned byte or short
  Indices,     // scalar: unsigned
  Matrix,      // mat4: float
  Float,       // scalar, vec3, vec4: float
  Keys,        // scalar, vec4: float, or normalised: rotations and morph weights
};

/// Reads accessor `index` as a table with a row per element, normalised integers decoded. `types` are the
/// TINYGLTF_TYPE_s that its place allows. Throws Error{Input} where its component type is not `legal`.
Rows read_rows(const GltfDocument& doc, int index, Legal legal, std::initializer_list<int> types);

/// The same for integers, without going through floating point.
std::vector<std::uint32_t> read_integers(const GltfDocument& doc, int index, Legal legal, int type);

}  // namespace skinlod
