// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pipeline/character.h"

/// Morph targets as levels of detail have them.
namespace skinlod {

/// Which targets the levels keep.
enum class MorphUse {
  Keep,       // all that move anything at the level
  Important,  // those that move some vertex by more than the level is off at rest
  None
};

/// What users call them, in that order.
inline constexpr std::array<const char*, 3> kMorphUseNames = {"keep", "important", "none"};

/// An offset shorter than this share of the diagonal is nothing: 0.02 mm on a person.
inline constexpr double kFaintMorph = 1e-5;

/// (1 - t) a + t b, over the morphs of either.
MorphOffsets blend(std::span<const MorphOffset> a, std::span<const MorphOffset> b, double t);

/// What `morph` adds; nothing where it is not among the offsets.
Vec3 offset_of(std::span<const MorphOffset> offsets, int morph);

/// What all of them add at these weights, one per morph; nothing for no weights.
Vec3 offset_of(std::span<const MorphOffset> offsets, std::span<const double> weights);

/// One more than the highest target that moves a vertex or a normal.
int morph_count(const Surface& surface);

/// The largest offset of each of `count` targets, metres.
std::vector<double> largest_offsets(const Surface& surface, int count);

/// Leaves out offsets that are shorter than `least` metres; then, of targets that move no vertex by more than
/// `least_of_target`, all that is left, their normals' offsets with it.
void drop_faint_morphs(Surface& surface, double least, double least_of_target = 0);

/// Takes all morph targets away, and the channels that move their weights.
void remove_morphs(Character& character);

}  // namespace skinlod
