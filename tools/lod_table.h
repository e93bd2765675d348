// SPDX-License-Identifier: MIT
#pragma once

#include <iosfwd>

#include "tools/report.h"

namespace skinlod {

/// What a cook made, for people: the source, the poses, and a line per level with its size and its posed
/// error in percent of the diagonal and in millimetres; then, where baselines were asked for, a line per
/// level and baseline.
void print_lod_table(std::ostream& out, const CookStory& story);

}  // namespace skinlod
