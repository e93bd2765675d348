// SPDX-License-Identifier: MIT
#include "pipeline/pose.h"

#include <algorithm>

#include "pipeline/morphs.h"
#include "pipeline/parallel.h"
#include "pipeline/rotation.h"
#include "pipeline/skin.h"

namespace skinlod {
namespace {

// A channel's value at key `k`.
VecX value(const Channel& channel, Eigen::Index k) {
  return channel.values.row(channel.interpolation == Interpolation::CubicSpline ? 3 * k + 1 : k).transpose();
}

// The Hermite spline of glTF 2.0, appendix C, from key `k`; tangents are per second.
VecX spline(const Channel& channel, Eigen::Index k, double t, double seconds) {
  const double t2 = t * t, t3 = t2 * t;
  const VecX out = channel.values.row(3 * k + 2).transpose(), in = channel.values.row(3 * k + 3).transpose();
  return (2 * t3 - 3 * t2 + 1) * value(channel, k) + seconds * (t3 - 2 * t2 + t) * out +
         (3 * t2 - 2 * t3) * value(channel, k + 1) + seconds * (t3 - t2) * in;
}

// A channel's value at `time`; rotations of unit length.
VecX value_at(const Channel& channel, double time) {
  const bool turns = channel.path == Path::Rotation;
  const auto of_unit_length = [&](const VecX& x) { return turns ? VecX(normalised(Quat(x))) : x; };
  const auto& times = channel.times;
  const auto next = std::upper_bound(times.begin(), times.end(), time);
  if (next == times.begin()) return of_unit_length(value(channel, 0));
  const Eigen::Index k = next - times.begin() - 1;
  if (next == times.end() || channel.interpolation == Interpolation::Step) {
    return of_unit_length(value(channel, k));
  }
  const double seconds = times[k + 1] - times[k], t = (time - times[k]) / seconds;
  if (channel.interpolation == Interpolation::CubicSpline) {
    return of_unit_length(spline(channel, k, t, seconds));
  }
  const VecX a = of_unit_length(value(channel, k)), b = of_unit_length(value(channel, k + 1));
  return turns ? VecX(slerp(a, b, t)) : VecX((1 - t) * a + t * b);
}

bool moves_its_node(const Channel& channel) {
  return channel.path != Path::MorphWeights && !channel.times.empty();
}

}  // namespace

std::vector<Transform> sample_transforms(const Skeleton& skeleton, const Clip& clip, double time) {
  std::vector<Transform> transforms;
  transforms.reserve(skeleton.nodes.size());
  for (const Node& node : skeleton.nodes) transforms.push_back(node.rest);
  for (const Channel& channel : clip.channels) {
    if (!moves_its_node(channel)) continue;
    Transform& transform = transforms[channel.node];
    const VecX x = value_at(channel, time);
    switch (channel.path) {
      case Path::Translation:
        transform.translation = x;
        break;
      case Path::Rotation:
        transform.rotation = x;
        break;
      case Path::Scale:
        transform.scale = x;
        break;
      case Path::MorphWeights:
        break;
    }
  }
  return transforms;
}

std::vector<Affine> sample_locals(const Skeleton& skeleton, const Clip& clip, double time) {
  std::vector<Affine> locals = rest_locals(skeleton);
  const std::vector<Transform> transforms = sample_transforms(skeleton, clip, time);
  for (const Channel& channel : clip.channels) {
    if (moves_its_node(channel)) locals[channel.node] = affine(transforms[channel.node]);
  }
  return locals;
}

Palette sample(const Skeleton& skeleton, const Clip& clip, double time) {
  return palette(skeleton, globals(skeleton, sample_locals(skeleton, clip, time)));
}

std::vector<double> sample_morph_weights(std::span<const Morph> morphs, const Clip& clip, double time) {
  std::vector<double> weights;
  for (const Morph& morph : morphs) weights.push_back(morph.weight);
  for (const Channel& channel : clip.channels) {
    if (channel.path != Path::MorphWeights || channel.times.empty()) continue;
    const VecX x = value_at(channel, time);
    Eigen::Index column = 0;  // the channel has one for each morph of its node
    for (size_t m = 0; m < morphs.size() && column < x.size(); ++m) {
      if (morphs[m].node == channel.node) weights[m] = x[column++];
    }
  }
  const bool off = std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0; });
  return off ? std::vector<double>() : weights;
}

std::vector<Vec3> pose_vertices(const Surface& surface, const Palette& palette,
                                std::span<const double> morph_weights) {
  return Skin(surface).posed(palette, morph_weights);
}

Rows pose_attributes(const Surface& surface, const Palette& palette, std::span<const double> morph_weights) {
  Rows posed = surface.attributes;
  const AttributeLayout& layout = surface.layout;
  if (!layout.normal && !layout.tangent) return posed;
  const auto turn = [&](Eigen::Index row, int at, const Mat3& by) {
    const Vec3 turned = by * posed.row(row).segment<3>(at).transpose();
    if (turned.squaredNorm() > 0) posed.row(row).segment<3>(at) = turned.normalized();
  };
  for_each_run(surface.wedges.size(), [&](size_t begin, size_t end) {
    for (size_t w = begin; w < end; ++w) {
      const Mat3 L = blend(surface.influences[surface.wedges[w].vertex], palette).leftCols<3>();
      Mat3 cofactor;  // the inverse transpose, but for its length
      for (int k = 0; k < 3; ++k) cofactor.col(k) = L.col((k + 1) % 3).cross(L.col((k + 2) % 3));
      if (L.determinant() < 0) cofactor = -cofactor;
      if (layout.normal) {
        if (!surface.normal_morphs.empty()) {
          posed.row(Eigen::Index(w)).segment<3>(layout.normal_at()) +=
              offset_of(surface.normal_morphs[w], morph_weights).transpose();
        }
        turn(Eigen::Index(w), layout.normal_at(), cofactor);
      }
      if (layout.tangent) turn(Eigen::Index(w), layout.tangent_at(), L);
    }
  });
  return posed;
}

}  // namespace skinlod
