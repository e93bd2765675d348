// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>

namespace skinlod {

/// Why a run failed. The values are the exit codes of the `skinlod` program.
enum class Fault {
  Usage = 2,       // the command line or an option's value
  Input = 3,       // a file is broken, or holds what we do not support
  Access = 4,      // a file cannot be read or written
  Ours = 5,        // a fault of this program
  Temporary = 75,  // a passing fault of the machine (disk full, out of memory): worth a retry
};

/// The one exception of the offline code, caught once, in `main`.
/// Its text reads "file: part: fact: remedy", leaving out what does not apply.
struct Error : std::runtime_error {
  Error(Fault why, const std::string& message) : std::runtime_error(message), fault(why) {}
  Fault fault;
};

}  // namespace skinlod
