// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "pipeline/pose.h"
#include "pipeline/sections.h"
#include "runtime/slod.h"

/// Boxes around a level in motion: what a .slod stores so that no vertex need be read to cull it.
namespace skinlod {

struct Box {
  Vec3 min = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 max = -min;

  void add(const Vec3& lowest, const Vec3& highest) {
    min = min.cwiseMin(lowest), max = max.cwiseMax(highest);
  }
  void add(const Box& other) { add(other.min, other.max); }
  bool contains(const Box& other) const {
    return (min.array() <= other.min.array()).all() && (max.array() >= other.max.array()).all();
  }
  /// As the floats next below and above, so that rounding lets no point out.
  void write(float* lowest, float* highest) const;
};

/// The box around where `m` takes a box.
Box transform(const Affine& m, const Box& box);

/// What can move each render vertex at rest: offsets at weight 1.
using Deltas = std::vector<std::vector<Vec3>>;

/// A render vertex as the file has it. Morphs at weights from 0 to 1 add at least the sum of all that is
/// negative and at most of all that is positive, in any axes.
struct BoundVertex {
  Vec3 point;
  std::span<const Vec3> deltas;
  std::span<const ByteInfluence> influences;  // heaviest first

  /// Where `m` takes it, with all morphs.
  Box under(const Affine& m) const;
};

std::vector<BoundVertex> bound_vertices(std::span<const Vec3> points, const Deltas& deltas,
                                        const Surface& surface, const VertexInfluences& influences,
                                        std::span<const int> wedges);

/// Box and sphere of the points at rest.
void add_rest_bounds(slod_level& record, std::span<const Vec3> points);

/// Per joint that one of the vertices follows, by ascending joint, the box around them in its node's space.
struct JointBox {
  int joint;
  Box box{};
};
std::vector<JointBox> joint_boxes(std::span<const BoundVertex> vertices, const Skeleton& skeleton);

/// Vertices that follow the same joints, and the same of them most.
struct GroupBox {
  Box box{};                            // at rest
  std::vector<int> joints{};            // the heaviest first, the others ascending
  std::vector<std::uint8_t> weights{};  // the largest of any vertex, per joint
};

std::vector<GroupBox> group_boxes(std::span<const BoundVertex> vertices);

/// The box around all vertices in all frames, of which there must be one.
slod_clip_box clip_box(std::span<const BoundVertex> vertices, std::span<const Palette> frames);

}  // namespace skinlod
