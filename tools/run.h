// SPDX-License-Identifier: MIT
#pragma once

#include <iosfwd>
#include <span>
#include <string>

namespace skinlod {

/// The whole program but `main`: results go to `out`, all else to `err`. Returns 0, or 1 for "ran, and the
/// answer is no"; throws Error. Tests call it in-process.
int run(std::span<const std::string> args, std::ostream& out, std::ostream& err);

}  // namespace skinlod
