// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/evaluate.h"
#include "pipeline/kept_joints.h"

/// What a level has in a part of its character and how far it is off there.
namespace skinlod {

struct Region {
  int triangles = 0;               // that follow the joints by half or more
  double inside = 0, outside = 0;  // RMS posed error, metres
};

/// The region that follows joints whose names match `pattern`, in `poses`.
inline Region region(const Character& character, const Surface& level, std::span<const Pose> poses,
                     const std::string& pattern) {
  const std::vector<std::string> labels = joint_labels(character.skeleton);
  std::vector<Influences> follows;  // entry 0 of each sample is how much it is inside
  const auto add = [&](const Surface& surface) {
    for (const Influences& joints : joints_of(surface, sample_by_area(surface, kSamples))) {
      double share = 0;
      for (const Influence& i : joints) share += matches(pattern, labels[i.joint]) ? i.weight : 0;
      follows.push_back({{0, share}, {1, 1 - share}});
    }
  };
  const Surface source = triangulated(character.surface);
  add(source), add(level);
  const Surface* const levels[] = {&level};
  const auto off = shares(follows, deviations(source, levels, poses, {.bound = false}).front(), 2);
  Region region{.inside = off[0].rms, .outside = off[1].rms};
  for (int f = 0; f < level.face_count(); ++f) {
    double share = 0;
    for (const int v : triangle_vertices(level, f)) {
      for (const Influence& i : level.influences[v])
        share += matches(pattern, labels[i.joint]) ? i.weight / 3 : 0;
    }
    region.triangles += share >= 0.5;
  }
  return region;
}

}  // namespace skinlod
