// SPDX-License-Identifier: MIT
#include "pipeline/bounds.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace skinlod {
namespace {

float below(double x) { return std::nextafter(float(x), -std::numeric_limits<float>::infinity()); }
float above(double x) { return std::nextafter(float(x), std::numeric_limits<float>::infinity()); }

// The joints of a vertex, the heaviest first and the others by their numbers.
std::vector<int> group_key(const BoundVertex& vertex) {
  std::vector<int> joints;
  for (const ByteInfluence& i : vertex.influences) joints.push_back(i.joint);
  std::sort(joints.begin() + 1, joints.end());
  return joints;
}

struct Group {
  Box box{};  // at rest
  std::vector<const BoundVertex*> vertices{};
};

std::map<std::vector<int>, Group> grouped(std::span<const BoundVertex> vertices) {
  std::map<std::vector<int>, Group> groups;  // by key
  for (const BoundVertex& v : vertices) {
    Group& group = groups[group_key(v)];
    group.box.add(v.under(identity()));
    group.vertices.push_back(&v);
  }
  return groups;
}

}  // namespace

void Box::write(float* lowest, float* highest) const {
  for (int i = 0; i < 3; ++i) lowest[i] = below(min[i]), highest[i] = above(max[i]);
}

Box transform(const Affine& m, const Box& box) {
  const Vec3 centre = transform(m, Vec3((box.min + box.max) / 2));
  const Vec3 reach = m.leftCols<3>().cwiseAbs() * (box.max - box.min) / 2;
  return {centre - reach, centre + reach};
}

Box BoundVertex::under(const Affine& m) const {
  const Vec3 x = transform(m, point);
  Box box{x, x};
  for (const Vec3& delta : deltas) {
    const Vec3 turned = m.leftCols<3>() * delta;
    box.min += turned.cwiseMin(0.0), box.max += turned.cwiseMax(0.0);
  }
  return box;
}

std::vector<BoundVertex> bound_vertices(std::span<const Vec3> points, const Deltas& deltas,
                                        const Surface& surface, const VertexInfluences& influences,
                                        std::span<const int> wedges) {
  std::vector<BoundVertex> vertices;
  for (size_t v = 0; v < wedges.size(); ++v) {
    const int vertex = surface.wedges[size_t(wedges[v])].vertex;
    vertices.push_back({points[v], deltas[v], influences[size_t(vertex)]});
  }
  return vertices;
}

void add_rest_bounds(slod_level& record, std::span<const Vec3> points) {
  Box box;
  for (const Vec3& x : points) box.add(x, x);
  box.write(record.box_min, record.box_max);
  for (int i = 0; i < 3; ++i) record.centre[i] = float((box.min[i] + box.max[i]) / 2);
  const Vec3 centre(record.centre[0], record.centre[1], record.centre[2]);
  for (const Vec3& x : points) record.radius = std::max(record.radius, above((x - centre).norm()));
}

std::vector<JointBox> joint_boxes(std::span<const BoundVertex> vertices, const Skeleton& skeleton) {
  std::map<int, Box> boxes;
  for (const BoundVertex& v : vertices) {
    for (const ByteInfluence& i : v.influences) {
      boxes[i.joint].add(v.under(skeleton.joints[size_t(i.joint)].inverse_bind));
    }
  }
  std::vector<JointBox> all;
  for (const auto& [joint, box] : boxes) all.push_back({joint, box});
  return all;
}

std::vector<GroupBox> group_boxes(std::span<const BoundVertex> vertices) {
  std::vector<GroupBox> all;
  for (const auto& [joints, group] : grouped(vertices)) {
    GroupBox& to = all.emplace_back(GroupBox{group.box, joints, std::vector<std::uint8_t>(joints.size())});
    for (const BoundVertex* v : group.vertices) {
      for (const ByteInfluence& i : v->influences) {
        std::uint8_t& weight = to.weights[size_t(std::ranges::find(joints, i.joint) - joints.begin())];
        weight = std::max(weight, i.weight);
      }
    }
  }
  return all;
}

slod_clip_box clip_box(std::span<const BoundVertex> vertices, std::span<const Palette> frames) {
  constexpr double kRounding = 1.0 / (1 << 18);  // of the floats that skin, in parts of what they add up
  const auto groups = grouped(vertices);
  Box box;
  for (const Palette& palette : frames) {
    for (const auto& [joints, group] : groups) {
      Box reach;  // a posed vertex is between where its joints alone would take it
      for (const int j : joints) reach.add(transform(palette[size_t(j)], group.box));
      if (box.contains(reach)) continue;
      for (const BoundVertex* v : group.vertices) {
        Affine blended = Affine::Zero();
        for (const ByteInfluence& i : v->influences) blended += palette[size_t(i.joint)] * (i.weight / 255.0);
        box.add(v->under(blended));
      }
    }
  }
  const double slack = kRounding * std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
  box.min.array() -= slack, box.max.array() += slack;
  slod_clip_box packed{};
  box.write(packed.box_min, packed.box_max);
  return packed;
}

}  // namespace skinlod
