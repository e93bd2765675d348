// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace skinlod {

/// All bytes of a file; "-" is standard input. Throws Error{Access}, with the system's reason.
std::vector<std::byte> read_file(const std::string& path);

/// Writes the bytes beside `path` under a random name, opened exclusively, and renames: `path` holds either
/// what it held before or all of `bytes`. "-" is standard output. Throws Error{Access}, or Error{Temporary}
/// where the disk is full.
void write_file(const std::string& path, std::span<const std::byte> bytes);

/// Removes every half-written file of this process. Safe to call in a signal handler.
void remove_unfinished_files() noexcept;

}  // namespace skinlod
