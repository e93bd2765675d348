// SPDX-License-Identifier: MIT
#pragma once

#include <iosfwd>
#include <span>
#include <string>

namespace skinlod {

/// The program skinlod_sheet: draws the levels of a .slod beside each other in bent poses, a row for each
/// pose, into a PNG. Needs the source for its clips and images. Returns 0; throws Error.
int draw_sheet(std::span<const std::string> args, std::ostream& out);

}  // namespace skinlod
