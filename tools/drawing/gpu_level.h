// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/pose.h"
#include "runtime/slod.h"

/// What an engine does with a .slod, done with OpenGL: the streams go to the GPU as the loader decodes them
/// and runtime/shaders/skinning.glsl draws them. A context must be current.
namespace skinlod {

/// A palette as slod_palette writes it: float[12] a joint.
std::vector<float> packed(const Palette& palette);

/// One level of an opened .slod on the GPU.
class GpuLevel {
 public:
  /// `morphs` has a weight for each morph of the file; where it is empty or zero all streams stay packed.
  GpuLevel(const slod_file& file, std::uint32_t level, std::span<const float> morphs = {});

  /// Takes the place of the texture coordinates: one number a render vertex, as (number, 0.5).
  void show(std::span<const float> values);

  const slod_level& record() const { return record_; }
  bool has_normals() const { return has_normals_; }

  /// The level as skinning.glsl poses it: three floats a render vertex.
  struct Posed {
    std::vector<float> positions, normals;
  };
  Posed posed(std::span<const float> palette) const;

  /// Binds `program`, the streams and the palette. `clip_from_world` is column-major.
  void begin(unsigned program, const std::array<float, 16>& clip_from_world,
             std::span<const float> palette) const;
  /// Draws section `s` of the file, which must be one of this level.
  void draw(std::uint32_t s) const;

 private:
  std::vector<std::uint8_t> decoded(std::uint32_t chunk) const;
  void add_stream(const slod_chunk& chunk, std::span<const std::uint8_t> bytes);
  void add_attribute(unsigned location, std::span<const float> values, int components);
  void add_morphed(std::span<const float> weights);
  void select(std::uint32_t s) const;

  // The bytes of the shader's `Section`.
  struct Constants {
    std::array<float, 16> clip_from_world;
    std::array<float, 4> position_base, position_step, uv_grid;
    std::uint32_t first_joint, unused[3];
  };

  const slod_file& file_;
  std::uint32_t level_;
  slod_level record_;
  Constants constants_{};
  unsigned arrays_ = 0, constant_buffer_ = 0, palette_buffer_ = 0, section_joint_buffer_ = 0, index_type_ = 0;
  std::size_t index_bytes_ = 0;
  bool has_normals_ = false;
};

/// skinning.glsl for levels of that many influence slots, linked with `fragment`; or where there is none with
/// its outputs captured. Throws Error{Ours} with the compiler's words.
unsigned skinning_program(std::uint32_t influence_slots, const std::optional<std::string>& fragment);

}  // namespace skinlod
