// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pipeline/character.h"

namespace skinlod {

/// Whether `name` is what `pattern` says, where * stands for any characters, also none, and ? for any one.
bool matches(std::string_view pattern, std::string_view name);

/// Which joints of a repaired character must not leave its levels, one entry per joint:
/// - those whose node's name matches one of `patterns`;
/// - those that all vertices of a part follow alone: a rigid prop;
/// - those that hold something: the nearest joint with vertices above a rigid prop on a node of its own, and
///   above a node that is no joint, has none below it and carries no mesh (an attachment, a socket, a
///   camera), unless it merely marks the end of its bone, as exporters add them: "hand_end", "Bip01 Head
///   Nub", or "Thumb4" below "Thumb3".
std::vector<bool> kept_joints(const Character& character, const std::vector<std::string>& patterns);

}  // namespace skinlod
