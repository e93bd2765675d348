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

/// The outputs of one action: all of them appear, or none. `add` writes each beside its target and finds out
/// nearly all that can go wrong; `commit` only renames, and where a rename fails puts the files back that it
/// has replaced. What is not committed vanishes with the set.
/// A link is written through to what it points at. Standard output ("-") and devices cannot be renamed to:
/// they get their bytes in `commit`, before any file is renamed.
class OutputSet {
 public:
  OutputSet() = default;
  OutputSet(const OutputSet&) = delete;
  OutputSet& operator=(const OutputSet&) = delete;
  ~OutputSet();

  void add(const std::string& path, std::span<const std::byte> bytes);
  void commit();

 private:
  struct Staged {
    std::string path;  // as the user wrote it, for messages
    std::string target;
    std::string temporary;
  };
  struct Stream {
    std::string path;
    std::vector<std::byte> bytes;
  };
  std::vector<Staged> staged_;
  std::vector<Stream> streams_;
};

/// Removes every half-written file of this process. Safe to call in a signal handler.
void remove_unfinished_files() noexcept;

}  // namespace skinlod
