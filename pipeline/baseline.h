// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pipeline/chain.h"

/// What others would have made of the same character, for users who want to know what they gain.
namespace skinlod {

/// A surface of triangles as `meshopt_simplify` takes it: on render vertices, which are our wedges.
class MeshoptInput {
 public:
  explicit MeshoptInput(const Surface& surface);

  /// The corners that it leaves, three for each of at most `triangles` triangles, with no limit on its error.
  std::vector<unsigned> simplified(size_t triangles) const;

 private:
  std::vector<unsigned> indices_;
  std::vector<float> points_;
};

/// What `meshopt_simplify` (Debian's meshoptimizer) makes of the bind pose, as engines call it: on render
/// vertices, which are our wedges, with no limit on its error. It moves no vertex, so attributes and weights
/// are the source's own, however many influences those are. At most `triangles`, or more where it stops
/// short or would leave nothing. Morphs are kept.
Surface meshopt_level(const Surface& source, int triangles);

enum class Baseline { Endpoint, MeshoptSimplify, RestPose, PoseIndependent };

/// What users call them, in that order.
inline constexpr std::array<const char*, 4> kBaselineNames = {"endpoint", "meshopt_simplify", "rest_pose",
                                                              "pose_independent"};

/// How far a baseline is from the source at one level.
struct BaselineLevel {
  int triangles = 0;  // more than the level's where the baseline could not go as far
  PosedError unseen_clip{}, unseen_motion{};
};

/// Each baseline at each level's own number of triangles and cap on influences: [baseline][level]. Level 0,
/// the source itself, is the same for all. `character` and `poses` are those the levels were made from.
std::vector<std::vector<BaselineLevel>> measure_baselines(const Character& character, const PoseSet& poses,
                                                          std::span<const Level> levels,
                                                          std::span<const Baseline> baselines);

}  // namespace skinlod
