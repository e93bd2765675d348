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

/// A folder that is there while something is written into it, and afterwards only if it is to be kept: those
/// that it has made vanish with it, unless something stands in them.
class MadeFolder {
 public:
  /// Makes the folder and those above it; none for "". Throws Error{Access}, or Error{Temporary} where the
  /// disk is full.
  explicit MadeFolder(const std::string& folder);
  MadeFolder(const MadeFolder&) = delete;
  MadeFolder& operator=(const MadeFolder&) = delete;
  ~MadeFolder() { remove(); }
  void keep() { made_.clear(); }

 private:
  void remove();
  std::vector<std::string> made_;  // outer folders first
};

/// Results that were lost must not look like success: throws Error{Temporary} where the disk behind standard
/// output is full, Error{Access} where nobody reads it any more.
void flush(std::ostream& out);

}  // namespace skinlod
