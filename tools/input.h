// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "tools/run.h"

namespace skinlod {

/// An input as the command line names it. "-" is standard input: its bytes are kept in a file without a name,
/// because importers read by path. So it is for formats of one file that their content tells (GLB, glTF with
/// data URIs, .slod).
class InputFile {
 public:
  /// Throws Error{Access} where standard input cannot be read.
  explicit InputFile(const std::string& argument);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::string& path() const { return path_; }  // to open it
  std::string name() const;                          // for reports: without folders
  bool is_slod() const;                              // by its first bytes, then by its extension

  /// The character in it; `Imported::files_read` holds no path that the user did not give.
  Imported character(const Readers& readers) const;

 private:
  std::string argument_, path_;
  int unnamed_ = -1;
};

/// What one --clips file gave.
struct ClipFile {
  std::string name;  // without folders
  std::vector<std::string> clips;
  int channels = 0;
  int bound = 0;
};

/// Reads the clips of each file into `source`, warnings and files read with them. A clip whose name is taken
/// (mixamo.com, Take 001) gets its file's name added, and a number where that is taken too.
std::vector<ClipFile> add_clips(Imported& source, const std::vector<std::string>& paths,
                                const Readers& readers);

/// The last part of a path: reports hold names, so that they are the same on every machine.
std::string file_name(const std::string& path);

}  // namespace skinlod
