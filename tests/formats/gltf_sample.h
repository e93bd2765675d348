// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// glTF files made in memory, for tests.
namespace skinlod {

/// A glTF file under construction: its JSON, for all to edit, and its one buffer.
struct GltfFile {
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}};
  std::vector<unsigned char> buffer = {};

  /// Adds bytes as a buffer view and returns its index.
  int view(std::span<const unsigned char> bytes);

  /// Adds an accessor with a buffer view of its own and returns its index. Values are encoded as
  /// `component_type` says, those of a `normalised` integer times its largest value.
  int accessor(const std::vector<double>& values, const std::string& type, int component_type = 5126,
               bool normalised = false);

  /// The file as GLB.
  std::vector<unsigned char> glb() const;
};

/// How the sample is encoded. Every choice of the first group makes the same character.
struct SampleOptions {
  int joints_type = 5121;
  int weights_type = 5126;
  int position_type = 5126;
  bool position_normalised = false;
  int normal_type = 5126;
  int uv_type = 5126;
  bool uv_normalised = false;
  int index_type = 5121;  // 0: not indexed
  bool strip = false;
  bool two_sets = false;  // the second influence in JOINTS_1
};

/// Two joints, "hip" and "knee" one above it; "body", a strip of four triangles over both, bent once, with
/// normals, coordinates and a morph target "bulge"; and "prop", a rigid triangle on a node below the knee. A
/// clip "walk" turns the knee (linear), lifts the hip (cubic) and bulges the body (step). Coordinates are 0
/// or 1 and weights 0, 1/5, 4/5, 1, which every type of number can say. Nodes: 0 root, 1 hip, 2 knee, 3 body,
/// 4 prop.
GltfFile sample_file(const SampleOptions& options = {});

/// Bytes as characters, to be written to a file.
inline std::string_view text(std::span<const unsigned char> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace skinlod
