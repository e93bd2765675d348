// SPDX-License-Identifier: MIT
#pragma once

#include <iosfwd>
#include <span>
#include <string>
#include <vector>

namespace skinlod {

/// A file that a command is going to write, and the option that asked for it.
struct Output {
  std::string option;
  std::string path;
};

/// Looks before the work at what could only fail after it: throws Error{Usage} where two outputs are the same
/// file, one is a folder, or one is also an input; Error{Access} where a folder is missing or not writable.
/// The folder of `made_folder` need not exist yet.
void check_outputs(std::span<const Output> outputs, std::span<const std::string> inputs,
                   const std::string& made_folder);

/// Makes the folder and those above it. Throws Error{Access}, or Error{Temporary} where the disk is full.
void make_folder(const std::string& folder);

/// Results that were lost must not look like success: throws Error{Temporary} where the disk behind standard
/// output is full, Error{Access} where nobody reads it any more.
void flush(std::ostream& out);

}  // namespace skinlod
