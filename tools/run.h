// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <iosfwd>
#include <span>
#include <string>

#include "formats/import.h"

namespace skinlod {

/// Where characters and clips come from. Tests put in readers that know `test:tube` and the like.
struct Readers {
  std::function<Imported(const std::string& path)> character = import_character;
  std::function<BoundClips(const std::string& path, const Skeleton& skeleton)> clips = import_clips;
};

/// The whole program but `main`: results go to `out`, all else to `err`. Returns 0, or 1 for "ran, and the
/// answer is no"; throws Error. Tests call it in-process.
int run(std::span<const std::string> args, std::ostream& out, std::ostream& err, const Readers& readers = {});

}  // namespace skinlod
