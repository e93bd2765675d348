// SPDX-License-Identifier: MIT
#version 450

// A vertex shader that draws one section of a .slod level straight from its packed streams, and agrees with
// slod_unpack and slod_skin (runtime/slod.h). Take what you need: the functions above `main` stand alone.
//
// Bind each decoded stream as a vertex buffer of its own, with these formats:
//   location 0  SLOD_POSITION      R16G16B16A16_UNORM   stride 8
//   location 1  SLOD_NORMAL        R16G16_SNORM         stride 4
//   location 2  SLOD_TANGENT       R8G8B8A8_SNORM       stride 4
//   location 3  SLOD_UV, set 0     R16G16_UNORM         stride 4
//   location 4  SLOD_JOINT_INDEX   R8G8B8A8_UINT        stride 4, or the first half of 8
//   location 5  SLOD_WEIGHT        R8G8B8A8_UNORM       stride 4, or the first half of 8
//   location 6  and 7              the second halves, where influence_slots is 8 (define SLOD_EIGHT_INFLUENCES)
// A level without one of these streams: bind a constant. Draw with first_index and index_count of the section,
// vertex offset 0. Binding 0 is slod_palette's output for the pose, shared by all levels and characters' sections;
// binding 1 the `joint` of each slod_section_joint; the constants come from slod_chunk and slod_section: for Vulkan
// they are pushed, for OpenGL (4.3 and later) they lie in uniform buffer 0, with the same bytes.

layout(location = 0) in vec4 position_unorm;
layout(location = 1) in vec2 normal_snorm;
layout(location = 2) in vec4 tangent_snorm;
layout(location = 3) in vec2 uv_unorm;
layout(location = 4) in uvec4 joints;
layout(location = 5) in vec4 weights;
#ifdef SLOD_EIGHT_INFLUENCES
layout(location = 6) in uvec4 more_joints;
layout(location = 7) in vec4 more_weights;
#endif

layout(std430, binding = 0) readonly buffer Palette { vec4 palette[]; };  // three rows a joint
layout(std430, binding = 1) readonly buffer SectionJoints { uint section_joint[]; };

#ifdef VULKAN
layout(push_constant)
#else
layout(std140, binding = 0)
#endif
uniform Section {
  mat4 clip_from_world;
  vec4 position_base;  // slod_chunk::base of SLOD_POSITION
  vec4 position_step;  // slod_chunk::step times 65535
  vec4 uv_grid;        // base in xy, step times 65535 in zw, of SLOD_UV
  uint first_joint;    // of the section
};

layout(location = 0) out vec3 world_normal;
layout(location = 1) out vec4 world_tangent;  // w: handedness
layout(location = 2) out vec2 uv;

// Meyer et al. 2010: the octahedron's lower half is folded outwards.
vec3 unfold_octahedron(vec2 e) {
  vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
  float fold = max(-n.z, 0.0);
  n.x += n.x < 0.0 ? fold : -fold;
  n.y += n.y < 0.0 ? fold : -fold;
  return normalize(n);
}

// Rows of a matrix that the weights blend.
struct Rows {
  vec4 x, y, z;
};

void add(inout Rows blend, uint local_joint, float weight) {
  uint row = 3u * section_joint[first_joint + local_joint];
  blend.x += weight * palette[row];
  blend.y += weight * palette[row + 1u];
  blend.z += weight * palette[row + 2u];
}

vec3 transform_point(Rows m, vec3 p) { return vec3(dot(m.x, vec4(p, 1)), dot(m.y, vec4(p, 1)), dot(m.z, vec4(p, 1))); }
vec3 transform_direction(Rows m, vec3 d) { return vec3(dot(m.x.xyz, d), dot(m.y.xyz, d), dot(m.z.xyz, d)); }

// By the inverse transpose up to a positive factor: right under uneven scale, and under mirrors.
vec3 transform_normal(Rows m, vec3 n) {
  vec3 a = cross(m.y.xyz, m.z.xyz), b = cross(m.z.xyz, m.x.xyz), c = cross(m.x.xyz, m.y.xyz);
  vec3 turned = vec3(dot(a, n), dot(b, n), dot(c, n));
  return dot(m.x.xyz, a) < 0.0 ? -turned : turned;
}

void main() {
  Rows blend = Rows(vec4(0), vec4(0), vec4(0));
  for (int i = 0; i < 4; ++i) add(blend, joints[i], weights[i]);
#ifdef SLOD_EIGHT_INFLUENCES
  for (int i = 0; i < 4; ++i) add(blend, more_joints[i], more_weights[i]);
#endif
  vec3 rest = position_base.xyz + position_step.xyz * position_unorm.xyz;
  gl_Position = clip_from_world * vec4(transform_point(blend, rest), 1.0);
  world_normal = normalize(transform_normal(blend, unfold_octahedron(normal_snorm)));
  vec3 tangent = transform_direction(blend, unfold_octahedron(tangent_snorm.xy));
  world_tangent = vec4(normalize(tangent), tangent_snorm.z < 0.0 ? -1.0 : 1.0);
  uv = uv_grid.xy + uv_grid.zw * uv_unorm;
}
