// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pipeline/character.h"

namespace skinlod {

/// The transforms of all nodes at `time` (seconds), as `sample_locals` has them; a node's own `rest` where no
/// channel moves it.
std::vector<Transform> sample_transforms(const Skeleton& skeleton, const Clip& clip, double time);

/// The locals of all nodes at `time` (seconds; held before the first and after the last key). Nodes without
/// a channel stay at rest. Rotations are interpolated by slerp of our own (rotation.h), never by glibc's.
std::vector<Affine> sample_locals(const Skeleton& skeleton, const Clip& clip, double time);

/// The palette of the clip at `time`.
Palette sample(const Skeleton& skeleton, const Clip& clip, double time);

/// The weight of each of `morphs` in the clip at `time`; the one at rest where no channel moves it. Empty
/// where all are 0.
std::vector<double> sample_morph_weights(std::span<const Morph> morphs, const Clip& clip, double time);

/// The blend of the palette that `influences` asks for: sum of w_b T_b.
inline Affine blend(std::span<const Influence> influences, const Palette& palette) {
  Affine sum = Affine::Zero();
  for (const auto& [joint, weight] : influences) sum += weight * palette[joint];
  return sum;
}

/// Every vertex where morphs and palette take it, as Skin has it (skin.h): for a surface that is posed once.
std::vector<Vec3> pose_vertices(const Surface& surface, const Palette& palette,
                                std::span<const double> morph_weights = {});

/// The attribute table where morphs and palette take it: normals with their morphs added, turned by the
/// inverse transpose of their vertex's blend, tangents by the blend itself, both of unit length again; where
/// the blend makes nothing of one it stays as it was. All else is as at rest.
Rows pose_attributes(const Surface& surface, const Palette& palette,
                     std::span<const double> morph_weights = {});

/// A palette, the morphs that are on, and where they came from.
struct Pose {
  std::string source;  // "bind", "clip walk at 0.4333 s", "range of motion 3", "morph smile": for the report
  Palette palette;
  std::vector<double> morph_weights = {};  // one per morph; or empty: all are 0
};

struct PoseOptions {
  int from_clips = 9;                     // example poses chosen from the clips
  int range_of_motion = 8;                // example poses made from the joints' limits
  std::vector<std::string> pose_clips{};  // clips of which every key is an example pose
  int unseen_clip_frames = 24;            // frames of the clips kept apart for validation
  int unseen_range_of_motion = 8;         // range-of-motion poses kept apart for validation
  int morphs = 24;                        // morph targets, each a pose by itself, that are measured
  double frames_per_second = 30;          // at which clips are looked at
  std::uint32_t seed = 1;                 // of the range-of-motion poses
};

/// The poses a cook works with. No pose is in two lists.
struct PoseSet {
  std::vector<Pose> examples;       // examples[0] is always the bind pose, the identity palette
  std::vector<Pose> unseen_clip;    // frames of the clips that are no examples
  std::vector<Pose> unseen_motion;  // range-of-motion poses from another seed
  std::vector<Pose> morphs;         // the bind pose with one morph target at weight 1
};

/// Chooses example poses for a repaired character, in this order: the bind pose; every key of the pose
/// clips; frames of the clips, each the farthest from all chosen before it, by the RMS distance of posed
/// vertices (500 of them) after the best rigid motion between the two is taken away; range-of-motion poses.
/// No two are nearer than 1e-6 of the diagonal, so there may be fewer than asked for, but for the keys of
/// pose clips, which are taken as they are. Clips of more than 2,000 frames together are thinned evenly.
/// Morphs have no part in the choice, but what is chosen carries their weights: the clip's, or those at rest.
///
/// A range-of-motion pose turns each joint about its rest by a rotation vector of independent components. The
/// limits of a component are the least and the largest seen in the clips, a tenth wider on both sides; a
/// joint that the clips turn by no more than 2 degrees stays still. Where no clip turns any joint, every
/// joint that vertices follow goes up to 35 degrees both ways. Roots stay: turning them moves everything
/// alike.
///
/// Of the morph targets those with the largest RMS offset are poses of their own, in the order of the file.
///
/// The same for any thread count. Throws Error{Usage} for a pose clip that is not there.
PoseSet choose_poses(const Character& character, const PoseOptions& options);

}  // namespace skinlod
