// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "pipeline/character.h"

/// Where errors count more than elsewhere, or less: a face that is looked at, a sole that nobody sees. It
/// steers what is collapsed and what levels are fitted to; errors that are measured are not touched by it.
namespace skinlod {

/// A part of a character, and the factor by which distances count there.
struct Importance {
  enum class Of { Joints, Material, Colour };
  Of of = Of::Joints;
  std::string pattern{};  // of the names of joints or materials, as in `matches`; of a colour r, g, b or a
  double factor = 1;      // 1 / kMostImportance to kMostImportance
};
inline constexpr double kMostImportance = 100;

/// How much of each vertex of a repaired character is selected, 0 to 1: the sum of its influences on joints
/// of the name; 1 where it has a face of the material; the channel of the first colour set, where a part has
/// one. The largest of its wedges counts.
std::vector<double> selected(const Character& character, const Importance& what);

/// Per vertex the product of 1 + (factor - 1) x selected over all selections: it grows with each factor, and
/// where the selection fades out, so does the factor. Empty where there is no selection.
/// Throws Error{Usage} where one is out of range or selects nothing.
std::vector<double> importance(const Character& character, std::span<const Importance> selections);

/// What squared errors on a face or an edge with these ends are multiplied by: the square of the ends' mean
/// importance.
double error_weight(const Surface& surface, std::span<const int> ends);

}  // namespace skinlod
