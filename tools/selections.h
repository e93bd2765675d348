// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/importance.h"

/// What options pick out of a character by name. All throw Error{Usage} in the name of the option, with a
/// guess at what was meant.
namespace skinlod {

/// "head*=4": joints by a pattern; "material:skin=2": materials by a pattern; "color:r=4": a channel.
Importance parse_importance(const std::string& text);

/// How a selection is written, without its factor.
std::string text(const Importance& what);

void check_pose_clips(const Character& character, const std::vector<std::string>& wanted);
void check_kept_joints(const Skeleton& skeleton, const std::vector<std::string>& patterns);
void check_importance(const Character& character, const std::vector<Importance>& selections);

}  // namespace skinlod
