// SPDX-License-Identifier: MIT

// skinning.glsl, which explains the streams and their formats, for Direct3D: vs_5_0 and later.

StructuredBuffer<float4> palette : register(t0);      // three rows a joint
StructuredBuffer<uint> section_joint : register(t1);  // `joint` of each slod_section_joint

cbuffer Section : register(b0) {
  row_major float4x4 clip_from_world;
  float4 position_base;  // slod_chunk::base of SLOD_POSITION
  float4 position_step;  // slod_chunk::step times 65535
  float4 uv_grid;        // base in xy, step times 65535 in zw, of SLOD_UV
  uint first_joint;      // of the section
};

struct PackedVertex {
  float4 position : POSITION;
  float2 normal : NORMAL;
  float4 tangent : TANGENT;
  float2 uv : TEXCOORD0;
  uint4 joints : BLENDINDICES0;
  float4 weights : BLENDWEIGHT0;
#ifdef SLOD_EIGHT_INFLUENCES
  uint4 more_joints : BLENDINDICES1;
  float4 more_weights : BLENDWEIGHT1;
#endif
};

struct PosedVertex {
  float4 clip : SV_Position;
  float3 normal : NORMAL;
  float4 tangent : TANGENT;  // w: handedness
  float2 uv : TEXCOORD0;
};

// Meyer et al. 2010: the octahedron's lower half is folded outwards.
float3 unfold_octahedron(float2 e) {
  float3 n = float3(e, 1.0 - abs(e.x) - abs(e.y));
  float fold = max(-n.z, 0.0);
  n.x += n.x < 0.0 ? fold : -fold;
  n.y += n.y < 0.0 ? fold : -fold;
  return normalize(n);
}

void add(inout float3x4 blend, uint local_joint, float weight) {
  uint row = 3 * section_joint[first_joint + local_joint];
  blend += weight * float3x4(palette[row], palette[row + 1], palette[row + 2]);
}

// By the inverse transpose up to a positive factor: right under uneven scale, and under mirrors.
float3 transform_normal(float3x3 m, float3 n) {
  float3x3 cofactors = float3x3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
  float3 turned = mul(cofactors, n);
  return dot(m[0], cofactors[0]) < 0.0 ? -turned : turned;
}

PosedVertex main(PackedVertex v) {
  float3x4 blend = (float3x4)0;
  for (int i = 0; i < 4; ++i) add(blend, v.joints[i], v.weights[i]);
#ifdef SLOD_EIGHT_INFLUENCES
  for (int k = 0; k < 4; ++k) add(blend, v.more_joints[k], v.more_weights[k]);
#endif
  float3 rest = position_base.xyz + position_step.xyz * v.position.xyz;
  float3 tangent = mul((float3x3)blend, unfold_octahedron(v.tangent.xy));

  PosedVertex posed;
  posed.clip = mul(clip_from_world, float4(mul(blend, float4(rest, 1.0)), 1.0));
  posed.normal = normalize(transform_normal((float3x3)blend, unfold_octahedron(v.normal)));
  posed.tangent = float4(normalize(tangent), v.tangent.z < 0.0 ? -1.0 : 1.0);
  posed.uv = uv_grid.xy + uv_grid.zw * v.uv;
  return posed;
}
