// SPDX-License-Identifier: MIT
#include "tools/outputs.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <ostream>

#include "pipeline/error.h"

namespace skinlod {
namespace {

namespace fs = std::filesystem;

bool same_file(const std::string& a, const std::string& b) {
  std::error_code unknown;
  if (fs::equivalent(a, b, unknown)) return true;
  return fs::weakly_canonical(a, unknown) == fs::weakly_canonical(b, unknown);
}

fs::path folder_of(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

void check_folder(const Output& output, fs::path folder, bool made) {
  std::error_code unknown;
  while (made && !fs::exists(folder, unknown)) {
    folder = folder.has_parent_path() ? folder.parent_path() : fs::path(".");
  }
  const std::string where = output.option + ": " + output.path + ": ";
  if (!fs::exists(folder, unknown)) {
    throw Error{Fault::Access, where + "there is no folder " + folder.string() + ": make it first"};
  }
  if (!fs::is_directory(folder, unknown)) {
    throw Error{Fault::Access, where + folder.string() + " is no folder: name another place"};
  }
  if (access(folder.c_str(), W_OK) != 0) {
    throw Error{Fault::Access, where + "cannot write to " + folder.string() + ": " + std::strerror(errno) +
                                   ": change its permissions or name another place"};
  }
}

}  // namespace

void check_outputs(std::span<const Output> outputs, std::span<const std::string> inputs,
                   const std::string& made_folder) {
  for (size_t i = 0; i < outputs.size(); ++i) {
    const auto& [option, path] = outputs[i];
    if (path == "-") continue;
    for (const std::string& input : inputs) {
      if (!same_file(path, input)) continue;
      throw Error{Fault::Usage,
                  option + ": " + path + ": is an input too, and would be overwritten: name another file"};
    }
    for (size_t k = 0; k < i; ++k) {
      if (outputs[k].path == "-" || !same_file(path, outputs[k].path)) continue;
      throw Error{Fault::Usage,
                  option + ": " + path + ": is written by " + outputs[k].option + " too: name another file"};
    }
    std::error_code unknown;
    if (fs::is_directory(path, unknown)) {
      throw Error{Fault::Usage, option + ": " + path + ": is a folder: name a file in it"};
    }
    const fs::path folder = folder_of(path);
    check_folder(outputs[i], folder, !made_folder.empty() && folder == folder_of(made_folder + "/x"));
  }
}

MadeFolder::MadeFolder(const std::string& folder) {
  std::error_code fault;
  fs::path path;
  for (const fs::path& name : fs::path(folder)) {
    path /= name;
    if (name.empty() || fs::is_directory(path, fault)) continue;
    if (fs::create_directory(path, fault)) made_.push_back(path.string());
    if (!fault) continue;
    remove();
    const bool full = fault == std::errc::no_space_on_device;
    throw Error{full ? Fault::Temporary : Fault::Access,
                folder + ": the folder cannot be made: " + fault.message() + ": name another place"};
  }
}

void MadeFolder::remove() {
  for (; !made_.empty(); made_.pop_back()) rmdir(made_.back().c_str());
}

void flush(std::ostream& out) {
  // A stream that has failed already leaves the reason of its last write; one that flushes leaves its own.
  if (out) errno = 0;
  if (out.flush()) return;
  const int why = errno;
  const bool full = why == ENOSPC || why == EDQUOT;
  throw Error{full ? Fault::Temporary : Fault::Access,
              std::string("standard output: cannot be written: ") +
                  (why != 0 ? std::strerror(why) : "it is closed") +
                  (full ? ": make room and try again" : ": check where it goes")};
}

}  // namespace skinlod
