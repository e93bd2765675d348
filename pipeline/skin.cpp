// SPDX-License-Identifier: MIT
#include "pipeline/skin.h"

#include "pipeline/morphs.h"
#include "pipeline/parallel.h"
#include "pipeline/pose.h"

namespace skinlod {

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
  for_each_run(points.size(), [&](size_t first, size_t last) {
    for (size_t v = first; v < last; ++v) {
      const int begin = v == 0 ? 0 : end_[v - 1];
      const auto its = std::span(influences_).subspan(size_t(begin), size_t(end_[v] - begin));
      Vec3 x = surface_.position[v];
      if (!surface_.morphs.empty()) x += offset_of(surface_.morphs[v], morph_weights);
      points[v] = transform(blend(its, palette), x);
    }
  });
  return points;
}

}  // namespace skinlod
