// SPDX-License-Identifier: MIT
#include "tools/drawing/renderer.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "pipeline/rotation.h"

namespace skinlod {
namespace {

constexpr int kSamplesPerPixel = 4;

constexpr const char* kFragment = R"(#version 450
layout(location = 0) in vec3 world_normal;
layout(location = 1) in vec4 world_tangent;
layout(location = 2) in vec2 uv;
layout(location = 0) out vec4 colour;
layout(std140, binding = 1) uniform Look {
  mat4 turn;         // the view from the world
  vec4 base_colour;  // linear
  vec4 pixel;        // metres a pixel in x and y, metres of depth
  bvec4 has;         // normals, image, two sides
};
layout(binding = 0) uniform sampler2D image;

void main() {
  vec3 seen = vec3(gl_FragCoord.xy, -gl_FragCoord.z) * pixel.xyz;
  vec3 facet = normalize(cross(dFdx(seen), dFdy(seen)));
  vec3 n = has.x ? normalize(mat3(turn) * world_normal) * (gl_FrontFacing ? 1.0 : -1.0) : facet;
  vec3 surface = base_colour.rgb * (has.y ? texture(image, uv).rgb : vec3(1));
  if (!gl_FrontFacing && !has.z) surface = vec3(0.8, 0.02, 0.02);
  float light = 0.12 + 0.62 * max(dot(n, normalize(vec3(0.5, 0.6, 0.7))), 0.0) + 0.26 * max(n.z, 0.0);
  colour = vec4(pow(surface * light, vec3(1.0 / 2.2)), 1);
}
)";

GLuint texture_of(const Picture& picture, GLint wrap) {
  GLuint texture = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &texture);
  const int levels = 1 + int(std::log2(std::max(picture.width, picture.height)));
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureStorage2D(texture, levels, GL_SRGB8, picture.width, picture.height);
  glTextureSubImage2D(texture, 0, 0, 0, picture.width, picture.height, GL_RGB, GL_UNSIGNED_BYTE,
                      picture.bytes.data());
  glGenerateTextureMipmap(texture);
  glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(texture, GL_TEXTURE_WRAP_S, wrap);
  glTextureParameteri(texture, GL_TEXTURE_WRAP_T, wrap);
  return texture;
}

// Colour and depth with `samples` samples a pixel.
GLuint target(int samples, int width, int height) {
  GLuint frame = 0, planes[2] = {};
  glCreateFramebuffers(1, &frame);
  glCreateRenderbuffers(2, planes);
  glNamedRenderbufferStorageMultisample(planes[0], samples, GL_RGBA8, width, height);
  glNamedRenderbufferStorageMultisample(planes[1], samples, GL_DEPTH_COMPONENT24, width, height);
  glNamedFramebufferRenderbuffer(frame, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, planes[0]);
  glNamedFramebufferRenderbuffer(frame, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, planes[1]);
  return frame;
}

// Column-major, right, up and near from -1 to 1 (near is -1).
std::array<float, 16> clip_from_world(const View& view) {
  std::array<float, 16> m{};
  const Vec3 scale(2 / view.size.x(), 2 / view.size.y(), -2 / view.size.z());
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) m[size_t(4 * c + r)] = float(scale[r] * view.turn(r, c));
    m[size_t(12 + r)] = float(-scale[r] * view.centre[r]);
  }
  m[15] = 1;
  return m;
}

// The bytes of the shader's `Look`.
struct Look {
  std::array<float, 16> turn{};
  std::array<float, 4> base_colour{1, 1, 1, 1}, pixel{};
  std::array<std::int32_t, 4> has{};
};

}  // namespace

View View::around(std::span<const Vec3> points, double degrees) {
  constexpr double kAbove = 12, kMargin = 1.04;
  const auto turn = [](double angle) { return angle * std::numbers::pi / 180; };
  const double c = std::cos(turn(degrees)), s = std::sin(turn(degrees));
  const double up = std::sin(turn(kAbove)), level = std::cos(turn(kAbove));
  View view;
  view.turn << c, 0, -s, -up * s, level, -up * c, level * s, up, level * c;
  Vec3 lowest = view.turn * points[0], highest = lowest;
  for (const Vec3& x : points) {
    lowest = lowest.cwiseMin(view.turn * x), highest = highest.cwiseMax(view.turn * x);
  }
  view.centre = (lowest + highest) / 2, view.size = kMargin * (highest - lowest).cwiseMax(1e-9);
  return view;
}

Renderer::Renderer(const slod_file& file, std::span<const Picture> images, int width, int height)
    : file_(file),
      width_(width),
      height_(height),
      samples_(target(kSamplesPerPixel, width, height)),
      pixels_(target(0, width, height)) {
  for (const Picture& image : images) textures_.push_back(image.width ? texture_of(image, GL_REPEAT) : 0);
  Picture ramp(4, 1);
  ramp.bytes = {255, 255, 255, 255, 220, 60, 215, 25, 20, 30, 0, 30};
  ramp_ = texture_of(ramp, GL_CLAMP_TO_EDGE);
  glTextureParameteri(ramp_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glCreateBuffers(1, &look_);
  glNamedBufferStorage(look_, sizeof(Look), nullptr, GL_DYNAMIC_STORAGE_BIT);
}

unsigned Renderer::program(std::uint32_t influence_slots) {
  const auto [place, fresh] = programs_.try_emplace(influence_slots, 0);
  if (fresh) place->second = skinning_program(influence_slots, kFragment);
  return place->second;
}

Picture Renderer::draw(const GpuLevel& level, std::span<const float> palette, const View& view, bool values) {
  // What is seen is enlarged to the shape of the picture.
  View shown = view;
  const double scale = std::max(view.size.x() / width_, view.size.y() / height_);
  shown.size.x() = scale * width_, shown.size.y() = scale * height_;

  glBindFramebuffer(GL_FRAMEBUFFER, samples_);
  glViewport(0, 0, width_, height_);
  glEnable(GL_DEPTH_TEST);
  glClearColor(0.87f, 0.89f, 0.92f, 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  level.begin(program(level.record().influence_slots), clip_from_world(shown), palette);
  glBindBufferBase(GL_UNIFORM_BUFFER, 1, look_);
  Look look;
  for (int i = 0; i < 9; ++i) look.turn[size_t(4 * (i % 3) + i / 3)] = float(view.turn(i / 3, i % 3));
  look.pixel = {float(scale), float(scale), float(view.size.z()), 0};

  const slod_level& record = level.record();
  for (std::uint32_t s = record.first_section; s < record.first_section + record.section_count; ++s) {
    const slod_part part = slod_get_part(&file_, slod_get_section(&file_, s).part);
    const slod_material material = slod_get_material(&file_, std::uint32_t(part.material));
    unsigned texture = values ? ramp_ : 0;
    look.base_colour = {0.8f, 0.8f, 0.8f, 1};
    if (values) look.base_colour = {1, 1, 1, 1};
    if (!values && part.material >= 0) {
      std::copy_n(material.base_colour, 4, look.base_colour.begin());
      if (size_t(part.material) < textures_.size()) texture = textures_[size_t(part.material)];
    }
    const bool two_sided = part.material >= 0 && (material.flags & SLOD_DOUBLE_SIDED) != 0;
    look.has = {level.has_normals() && part.has_normal, texture != 0, two_sided || values, 0};
    glNamedBufferSubData(look_, 0, sizeof look, &look);
    glBindTextureUnit(0, texture);
    level.draw(s);
  }

  glBlitNamedFramebuffer(samples_, pixels_, 0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT,
                         GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, pixels_);
  Picture upside_down(width_, height_), picture(width_, height_);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, upside_down.bytes.data());
  const size_t row = 3 * size_t(width_);
  for (size_t y = 0; y < size_t(height_); ++y) {
    std::copy_n(upside_down.bytes.begin() + std::ptrdiff_t((size_t(height_) - 1 - y) * row), row,
                picture.bytes.begin() + std::ptrdiff_t(y * row));
  }
  return picture;
}

Picture Renderer::draw(const GpuLevel& level, std::span<const float> palette, const View& view) {
  return draw(level, palette, view, false);
}

Picture Renderer::draw_values(const GpuLevel& level, std::span<const float> palette, const View& view) {
  return draw(level, palette, view, true);
}

}  // namespace skinlod
