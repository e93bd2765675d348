// SPDX-License-Identifier: MIT
#pragma once

#include <iosfwd>
#include <span>
#include <string>

#include "tools/run.h"

namespace skinlod {

/// What a command talks to.
struct Console {
  std::ostream& out;  // results
  std::ostream& err;  // warnings, progress
  const Readers& readers;
};

/// The commands, each in a file of its own. `args` are the words after the command's name; the result is that
/// of `run`.
int cook_command(std::span<const std::string> args, const Console& console);
int evaluate_command(std::span<const std::string> args, const Console& console);
int inspect_command(std::span<const std::string> args, const Console& console);
int explain_command(std::span<const std::string> args, const Console& console);
int formats_command(std::span<const std::string> args, const Console& console);

}  // namespace skinlod
