// SPDX-License-Identifier: MIT
#include "pipeline/skin.h"

#include <tbb/parallel_for.h>

namespace skinlod {

Vec3 morph_offset(const MorphOffsets& offsets, std::span<const double> weights) {
  Vec3 sum = Vec3::Zero();
  if (weights.empty()) return sum;
  for (const auto& [morph, delta] : offsets) {
    if (weights[morph] != 0) sum += weights[morph] * delta;
  }
  return sum;
}

Skin::Skin(const Surface& surface) : surface_(surface) {
  size_t count = 0;
  for (const Influences& its : surface.influences) count += its.size();
  influences_.reserve(count), end_.reserve(surface.influences.size());
  for (const Influences& its : surface.influences) {
    influences_.insert(influences_.end(), its.begin(), its.end());
    end_.push_back(int(influences_.size()));
  }
}

std::vector<Vec3> Skin::posed(const Palette& palette, std::span<const double> morph_weights) const {
  std::vector<Vec3> points(surface_.position.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, points.size(), 1024), [&](const auto& range) {
    for (size_t v = range.begin(); v != range.end(); ++v) {
      Affine blended = Affine::Zero();
      for (int i = v == 0 ? 0 : end_[v - 1]; i < end_[v]; ++i)
        blended += influences_[i].weight * palette[influences_[i].joint];
      Vec3 x = surface_.position[v];
      if (!surface_.morphs.empty()) x += morph_offset(surface_.morphs[v], morph_weights);
      points[v] = transform(blended, x);
    }
  });
  return points;
}

}  // namespace skinlod
