// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/chain.h"

/// How levels are written on a command line and read back in reports.
namespace skinlod {

/// "50%,25%,2000": shares of the source's triangles and numbers of triangles, from fine to coarse.
/// Throws Error{Usage}, as all below, in the name of the option.
std::vector<LevelTarget> parse_lods(const std::string& list);

/// "0.1%,0.5%": RMS posed errors in percent of the rest diagonal, from fine to coarse.
std::vector<LevelTarget> parse_max_errors(const std::string& list);

/// "4" for all levels, or "4,4,2,1", one for each.
void set_max_influences(std::vector<LevelTarget>& targets, const std::string& list);

/// "80,40,20": how many joints each level may have; joints never return. Or one number for all.
void set_max_joints(std::vector<LevelTarget>& targets, const std::string& list);

/// "0.02%,0.1%": for each level what the joints that left may cost, in percent of the rest diagonal. Or one
/// for all.
void set_joint_errors(std::vector<LevelTarget>& targets, const std::string& list);

/// Levels must go from fine to coarse also where shares and numbers are mixed, which only the source's
/// triangles tell.
void check_order(const std::vector<LevelTarget>& targets, int source_triangles);

/// A remark for somebody who wrote 50 and seems to have meant 50%; nothing where there is no reason for one.
std::optional<std::string> doubt(const std::vector<LevelTarget>& targets, int source_triangles);

/// "50%", "2000 triangles", "error 0.2%", each with " and 40 joints" or " and joint error 0.1%" where asked
/// for.
std::string text(const LevelTarget& target);

}  // namespace skinlod
