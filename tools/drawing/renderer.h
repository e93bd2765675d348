// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <span>
#include <vector>

#include "pipeline/linalg.h"
#include "tools/drawing/gpu_level.h"
#include "tools/drawing/picture.h"

namespace skinlod {

/// An orthographic view on a box of the world.
struct View {
  Mat3 turn = Mat3::Identity();  // from the world to right, up, and towards the eye
  Vec3 centre = Vec3::Zero();    // of what is seen, after the turn; metres
  Vec3 size = Vec3::Ones();      // what is seen in each of these directions; metres

  /// All of `points`, which are not empty, seen from `degrees` to the right of +z and a little above.
  static View around(std::span<const Vec3> points, double degrees);
};

/// Draws levels of one opened .slod with the light where the eye is and to its upper right. Both sides of
/// every triangle are drawn; the inner side is red where the material has one side, so that holes show.
class Renderer {
 public:
  /// `images` has the base colour image of each material, of no size where it has none; or is empty.
  Renderer(const slod_file& file, std::span<const Picture> images, int width, int height);

  /// With the materials' colours and images.
  Picture draw(const GpuLevel& level, std::span<const float> palette, const View& view);

  /// What `GpuLevel::show` has given: 0 white, then yellow and red, 1 and above black.
  Picture draw_values(const GpuLevel& level, std::span<const float> palette, const View& view);

 private:
  Picture draw(const GpuLevel& level, std::span<const float> palette, const View& view, bool values);
  unsigned program(std::uint32_t influence_slots);

  const slod_file& file_;
  int width_, height_;
  std::vector<unsigned> textures_;  // of each material; 0: none
  unsigned ramp_ = 0, samples_ = 0, pixels_ = 0, look_ = 0;
  std::map<std::uint32_t, unsigned> programs_{};  // by influence slots
};

}  // namespace skinlod
