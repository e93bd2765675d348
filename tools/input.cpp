// SPDX-License-Identifier: MIT
#include "tools/input.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "formats/file.h"
#include "pipeline/error.h"

namespace skinlod {
namespace {

// A descriptor of the memory that holds `bytes`, with a path of its own under /proc.
int unnamed_file(std::span<const std::byte> bytes) {
  const int fd = memfd_create("skinlod-stdin", MFD_CLOEXEC);
  bool kept = fd >= 0;
  for (size_t done = 0; kept && done < bytes.size();) {
    const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
    if (n > 0) done += size_t(n);
    kept = n > 0 || (n < 0 && errno == EINTR);
  }
  if (kept) return fd;
  const std::string why = std::strerror(errno);
  if (fd >= 0) close(fd);
  throw Error{Fault::Temporary, "standard input: cannot be kept in memory: " + why + ": name a file instead"};
}

}  // namespace

std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

InputFile::InputFile(const std::string& argument) : argument_(argument), path_(argument) {
  if (argument != "-") return;
  unnamed_ = unnamed_file(read_file("-"));
  path_ = "/proc/self/fd/" + std::to_string(unnamed_);
}

InputFile::~InputFile() {
  if (unnamed_ >= 0) close(unnamed_);
}

std::string InputFile::name() const { return argument_ == "-" ? "-" : file_name(argument_); }

bool InputFile::is_slod() const {
  char start[4] = {};
  std::ifstream(path_, std::ios::binary).read(start, sizeof start);
  return std::memcmp(start, "SLOD", sizeof start) == 0 || path_.ends_with(".slod");
}

Imported InputFile::character(const Readers& readers) const {
  if (unnamed_ < 0) return readers.character(path_);
  try {
    Imported imported = readers.character(path_);
    std::erase(imported.files_read, path_);
    return imported;
  } catch (const Error& e) {
    std::string message = e.what();
    if (const size_t at = message.find(path_); at != std::string::npos) {
      message.replace(at, path_.size(), "standard input");
    }
    throw Error{e.fault, message};
  }
}

std::vector<ClipFile> add_clips(Imported& source, const std::vector<std::string>& paths,
                                const Readers& readers) {
  std::vector<ClipFile> files;
  for (const std::string& path : paths) {
    BoundClips bound = readers.clips(path, source.character.skeleton);
    ClipFile& file = files.emplace_back();
    file = {.name = file_name(path), .clips = {}, .channels = bound.channels, .bound = bound.bound};
    for (Clip& clip : bound.clips) {
      clip.name = free_clip_name(source.character, clip.name, std::filesystem::path(path).stem().string());
      file.clips.push_back(clip.name);
      source.character.clips.push_back(std::move(clip));
    }
    for (Warning& warning : bound.warnings) warn(source.warnings, std::move(warning));
    source.files_read.insert(source.files_read.end(), bound.files_read.begin(), bound.files_read.end());
  }
  return files;
}

}  // namespace skinlod
