// SPDX-License-Identifier: MIT
#include "tools/drawing/gpu_level.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cstddef>

#include "formats/file.h"
#include "pipeline/error.h"
#include "pipeline/pack_level.h"

namespace skinlod {
namespace {

// Where skinning.glsl has a stream, and as what.
struct Attribute {
  slod_kind kind;
  GLuint location;
  GLint components;
  GLenum type;
};
constexpr Attribute kAttributes[] = {{SLOD_POSITION, 0, 4, GL_UNSIGNED_SHORT},
                                     {SLOD_NORMAL, 1, 2, GL_SHORT},
                                     {SLOD_TANGENT, 2, 4, GL_BYTE},
                                     {SLOD_UV, 3, 2, GL_UNSIGNED_SHORT},
                                     {SLOD_JOINT_INDEX, 4, 4, GL_UNSIGNED_BYTE},
                                     {SLOD_WEIGHT, 5, 4, GL_UNSIGNED_BYTE}};
constexpr GLuint kSecondHalf = 2;  // from the location of joints or weights to that of the slots 4 to 7

GLuint buffer_of(const void* bytes, size_t size) {
  GLuint buffer = 0;
  glCreateBuffers(1, &buffer);
  glNamedBufferStorage(buffer, GLsizeiptr(size), bytes, GL_DYNAMIC_STORAGE_BIT);
  return buffer;
}

void require_good(GLuint object, GLenum what, auto* get, auto* get_log) {
  GLint good = 0;
  get(object, what, &good);
  if (good) return;
  char log[2000] = "";
  get_log(object, sizeof log, nullptr, log);
  throw Error{Fault::Ours, std::string("shader: ") + log};
}

GLuint compiled(GLenum stage, const std::string& source) {
  const GLuint shader = glCreateShader(stage);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  require_good(shader, GL_COMPILE_STATUS, glGetShaderiv, glGetShaderInfoLog);
  return shader;
}

}  // namespace

std::vector<float> packed(const Palette& palette) {
  std::vector<float> rows;
  for (const Affine& m : palette) {
    for (int i = 0; i < 12; ++i) rows.push_back(float(m(i / 4, i % 4)));
  }
  return rows;
}

GpuLevel::GpuLevel(const slod_file& file, std::uint32_t level, std::span<const float> morphs)
    : file_(file), level_(level), record_(slod_get_level(&file, level)) {
  glCreateVertexArrays(1, &arrays_);
  for (std::uint32_t c = record_.first_chunk; c < record_.first_chunk + record_.chunk_count; ++c) {
    const slod_chunk chunk = slod_get_chunk(&file, c);
    if (chunk.set == 0) add_stream(chunk, decoded(c));
  }
  if (std::ranges::any_of(morphs, [](float w) { return w != 0; })) add_morphed(morphs);

  std::vector<std::uint32_t> joints;
  for (std::uint32_t j = 0; j < slod_count(&file, SLOD_SECTION_JOINTS); ++j) {
    joints.push_back(slod_get_section_joint(&file, j).joint);
  }
  section_joint_buffer_ = buffer_of(joints.data(), joints.size() * sizeof joints[0]);
  constant_buffer_ = buffer_of(nullptr, sizeof constants_);
  palette_buffer_ = buffer_of(nullptr, slod_count(&file, SLOD_JOINTS) * 12 * sizeof(float));
}

// Empty for kinds that the loader does not decode.
std::vector<std::uint8_t> GpuLevel::decoded(std::uint32_t chunk) const {
  constexpr slod_codecs kCodecs{meshopt_decodeVertexBuffer, meshopt_decodeIndexBuffer};
  const slod_chunk c = slod_get_chunk(&file_, chunk);
  std::vector<std::uint8_t> bytes(size_t(c.count) * c.stride);
  const slod_status status = slod_decode(&file_, chunk, &kCodecs, bytes.data(), bytes.size());
  if (status == SLOD_BAD_ARGUMENT) return {};
  if (status != SLOD_OK) throw Error{Fault::Input, std::string("a stream: ") + slod_status_text(status)};
  return bytes;
}

void GpuLevel::add_stream(const slod_chunk& chunk, std::span<const std::uint8_t> bytes) {
  if (chunk.kind == SLOD_INDEX) {
    index_bytes_ = chunk.stride;
    index_type_ = chunk.stride == 2 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT;
    glVertexArrayElementBuffer(arrays_, buffer_of(bytes.data(), bytes.size()));
  }
  const auto a = std::ranges::find(kAttributes, chunk.kind, &Attribute::kind);
  if (a == std::end(kAttributes)) return;
  const GLuint buffer = buffer_of(bytes.data(), bytes.size());
  for (GLuint half = 0; half < (a->kind == SLOD_JOINT_INDEX || a->kind == SLOD_WEIGHT ? chunk.stride / 4 : 1);
       ++half) {
    const GLuint location = a->location + half * kSecondHalf;
    glEnableVertexArrayAttrib(arrays_, location);
    glVertexArrayVertexBuffer(arrays_, location, buffer, GLintptr(4 * half), GLsizei(chunk.stride));
    if (a->kind == SLOD_JOINT_INDEX) {
      glVertexArrayAttribIFormat(arrays_, location, a->components, a->type, 0);
    } else {
      glVertexArrayAttribFormat(arrays_, location, a->components, a->type, GL_TRUE, 0);
    }
    glVertexArrayAttribBinding(arrays_, location, location);
  }
  constexpr float kUnorm = 65535;
  if (chunk.kind == SLOD_POSITION) {
    for (size_t i = 0; i < 3; ++i) {
      constants_.position_base[i] = chunk.base[i], constants_.position_step[i] = chunk.step[i] * kUnorm;
    }
  } else if (chunk.kind == SLOD_UV) {
    constants_.uv_grid = {chunk.base[0], chunk.base[1], chunk.step[0] * kUnorm, chunk.step[1] * kUnorm};
  }
  has_normals_ = has_normals_ || chunk.kind == SLOD_NORMAL;
}

void GpuLevel::add_attribute(unsigned location, std::span<const float> values, int components) {
  glEnableVertexArrayAttrib(arrays_, location);
  glVertexArrayVertexBuffer(arrays_, location, buffer_of(values.data(), values.size_bytes()), 0,
                            components * GLsizei(sizeof(float)));
  glVertexArrayAttribFormat(arrays_, location, components, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(arrays_, location, location);
}

// Morphs are added before skinning, as slod_add_morphs does it; the shader then gets floats for integers.
void GpuLevel::add_morphed(std::span<const float> weights) {
  const std::uint32_t offsets = slod_find(&file_, level_, SLOD_MORPH_OFFSET, 0);
  if (offsets == SLOD_NONE) return;
  const auto unpacked = [&](slod_kind kind) {
    const std::uint32_t c = slod_find(&file_, level_, kind, 0);
    const slod_chunk chunk = slod_get_chunk(&file_, c);
    std::vector<float> values(size_t(chunk.count) * slod_components(&chunk));
    if (!values.empty()) slod_unpack(&chunk, decoded(c).data(), values.data());
    return values;
  };
  std::vector<float> positions = unpacked(SLOD_POSITION), normals = unpacked(SLOD_NORMAL), folded;
  const auto ranges = decoded(slod_find(&file_, level_, SLOD_MORPH_RANGE, 0));
  const auto deltas = decoded(offsets);
  const slod_chunk chunk = slod_get_chunk(&file_, offsets);
  slod_add_morphs(&file_, &chunk, reinterpret_cast<const std::uint32_t*>(ranges.data()),
                  reinterpret_cast<const slod_morph_offset*>(deltas.data()), weights.data(), positions.data(),
                  normals.empty() ? nullptr : normals.data());
  add_attribute(0, positions, 3);
  constants_.position_base = {}, constants_.position_step = {1, 1, 1, 1};
  for (size_t i = 0; i < normals.size(); i += 3) {
    const auto [x, y] = fold_octahedron(Vec3(normals[i], normals[i + 1], normals[i + 2]));
    folded.insert(folded.end(), {float(x), float(y)});
  }
  if (has_normals_) add_attribute(1, folded, 2);
}

void GpuLevel::show(std::span<const float> values) {
  std::vector<float> uvs;
  for (const float value : values) uvs.insert(uvs.end(), {value, 0.5f});
  add_attribute(3, uvs, 2);
  constants_.uv_grid = {0, 0, 1, 1};
}

void GpuLevel::begin(unsigned program, const std::array<float, 16>& clip_from_world,
                     std::span<const float> palette) const {
  Constants constants = constants_;
  constants.clip_from_world = clip_from_world;
  glNamedBufferSubData(constant_buffer_, 0, sizeof constants, &constants);
  glNamedBufferSubData(palette_buffer_, 0, GLsizeiptr(palette.size_bytes()), palette.data());
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, constant_buffer_);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, palette_buffer_);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, section_joint_buffer_);
  glBindVertexArray(arrays_);
  glUseProgram(program);
}

void GpuLevel::select(std::uint32_t s) const {
  const std::uint32_t first_joint = slod_get_section(&file_, s).first_joint;
  glNamedBufferSubData(constant_buffer_, offsetof(Constants, first_joint), sizeof first_joint, &first_joint);
}

void GpuLevel::draw(std::uint32_t s) const {
  const slod_section section = slod_get_section(&file_, s);
  select(s);
  glDrawElements(GL_TRIANGLES, GLsizei(section.index_count), index_type_,
                 reinterpret_cast<const void*>(section.first_index * index_bytes_));
}

GpuLevel::Posed GpuLevel::posed(std::span<const float> palette) const {
  const unsigned program = skinning_program(record_.influence_slots, {});
  begin(program, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, palette);
  struct Captured {
    float position[4], normal[3];
  };
  std::vector<Captured> captured(record_.vertex_count);
  const GLuint buffer = buffer_of(captured.data(), captured.size() * sizeof(Captured));
  glEnable(GL_RASTERIZER_DISCARD);
  for (std::uint32_t s = record_.first_section; s < record_.first_section + record_.section_count; ++s) {
    const slod_section section = slod_get_section(&file_, s);
    select(s);
    glBindBufferRange(GL_TRANSFORM_FEEDBACK_BUFFER, 0, buffer,
                      GLintptr(section.first_vertex * sizeof(Captured)),
                      GLsizeiptr(section.vertex_count * sizeof(Captured)));
    glBeginTransformFeedback(GL_POINTS);
    glDrawArrays(GL_POINTS, GLint(section.first_vertex), GLsizei(section.vertex_count));
    glEndTransformFeedback();
  }
  glDisable(GL_RASTERIZER_DISCARD);
  glGetNamedBufferSubData(buffer, 0, GLsizeiptr(captured.size() * sizeof(Captured)), captured.data());
  Posed posed;
  for (const auto& [position, normal] : captured) {
    posed.positions.insert(posed.positions.end(), position, position + 3);
    posed.normals.insert(posed.normals.end(), normal, normal + 3);
  }
  return posed;
}

unsigned skinning_program(std::uint32_t influence_slots, const std::optional<std::string>& fragment) {
  const auto bytes = read_file(SKINLOD_SHADERS "/skinning.glsl");
  std::string vertex(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string version = "#version 450\n";
  if (influence_slots > 4)
    vertex.insert(vertex.find(version) + version.size(), "#define SLOD_EIGHT_INFLUENCES\n");
  const GLuint program = glCreateProgram();
  glAttachShader(program, compiled(GL_VERTEX_SHADER, vertex));
  if (fragment) {
    glAttachShader(program, compiled(GL_FRAGMENT_SHADER, *fragment));
  } else {
    const char* outputs[] = {"gl_Position", "world_normal"};
    glTransformFeedbackVaryings(program, 2, outputs, GL_INTERLEAVED_ATTRIBS);
  }
  glLinkProgram(program);
  require_good(program, GL_LINK_STATUS, glGetProgramiv, glGetProgramInfoLog);
  return program;
}

}  // namespace skinlod
