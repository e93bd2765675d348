// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "pipeline/closest.h"
#include "pipeline/evaluate.h"
#include "pipeline/skin.h"

namespace skinlod {

/// A surface that is looked at in all poses, and the points on it that are looked from.
struct Moving {
  Moving(const Animated& animated, int count)
      : surface(*animated.surface),
        poses(animated.poses),
        skin(surface),
        tree(std::make_shared<FaceTree>(surface)),
        samples(sample_by_area(surface, count)) {}

  std::vector<Vec3> points(size_t p) const { return skin.posed(poses[p].palette, poses[p].morph_weights); }
  PosedSurface in(size_t p) const { return PosedSurface(tree, points(p)); }

  const Surface& surface;
  std::span<const Pose> poses;
  Skin skin;
  std::shared_ptr<const FaceTree> tree;
  std::vector<Place> samples;
};

}  // namespace skinlod
