// SPDX-License-Identifier: MIT
#include "formats/file.h"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <new>
#include <system_error>
#include <utility>

#include "pipeline/error.h"

namespace skinlod {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, const std::string& what, int error) {
  const std::string fact = path + ": " + what + ": " + std::generic_category().message(error);
  if (error == ENOSPC || error == EDQUOT) {
    throw Error(Fault::Temporary, fact + ": make room and run again");
  }
  throw Error(Fault::Access, fact + ": check the path and its permissions");
}

// The names of the files being written. A signal handler may not take locks or allocate, so they stand in a
// fixed array; whoever takes a name out owns it.
std::array<std::atomic<char*>, 256> unfinished{};
static_assert(std::atomic<char*>::is_always_lock_free);

void remember(const std::string& name) {
  char* copy = ::strdup(name.c_str());
  if (!copy) throw std::bad_alloc();
  for (auto& slot : unfinished) {
    char* empty = nullptr;
    if (slot.compare_exchange_strong(empty, copy)) return;
  }
  std::free(copy);
  throw Error(Fault::Ours, name + ": more than 256 files are being written at once");
}

void forget(const std::string& name) {
  for (auto& slot : unfinished) {
    char* held = slot.load();
    if (held && name == held && slot.compare_exchange_strong(held, nullptr)) return std::free(held);
  }
}

void discard(const std::string& name) {
  ::unlink(name.c_str());
  forget(name);
}

/// Owns a descriptor. `close` tells whether all that was written has arrived; the destructor does not.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ > STDERR_FILENO) ::close(fd_);
  }
  int get() const { return fd_; }
  bool close() { return ::close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

bool write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    bytes = bytes.subspan(size_t(n));
  }
  return true;
}

std::string random_name(const fs::path& folder) {
  std::array<unsigned char, 8> random{};
  if (::getrandom(random.data(), random.size(), 0) != ssize_t(random.size())) {
    fail(folder.string(), "no random name for a temporary file", errno);
  }
  std::string name = ".skinlod-";
  for (const unsigned char byte : random) {
    name += "0123456789abcdef"[byte >> 4];
    name += "0123456789abcdef"[byte & 15];
  }
  return (folder / name).string();
}

/// Where a chain of links ends, whether or not anything is there: a rename would replace the link itself.
std::string link_target(const std::string& path) {
  fs::path target = path;
  std::error_code error;
  for (int links = 0; fs::is_symlink(target, error); ++links) {
    if (links == 40) fail(path, "cannot be written", ELOOP);
    target = target.parent_path() / fs::read_symlink(target, error);
    if (error) fail(path, "cannot be written", error.value());
  }
  return target.string();
}

/// Files renamed over others one by one. Each old file keeps a second name, by which it goes back unless all
/// is settled; on a file system without hard links it cannot.
class Replacements {
 public:
  Replacements() = default;
  Replacements(const Replacements&) = delete;
  Replacements& operator=(const Replacements&) = delete;
  ~Replacements() {
    for (auto file = files_.rbegin(); file != files_.rend(); ++file) {
      if (file->old.empty()) {
        ::unlink(file->target.c_str());
      } else {
        ::rename(file->old.c_str(), file->target.c_str());
        forget(file->old);  // also where that failed: better under a strange name than gone
      }
    }
  }

  /// Renames `temporary` to `target`; 0, or the reason why that failed. The last file need not go back.
  int replace(const std::string& target, const std::string& temporary, bool can_go_back) {
    std::string old;
    if (can_go_back) {
      old = random_name(fs::path(target).parent_path());
      remember(old);
      if (::link(target.c_str(), old.c_str()) != 0) {
        can_go_back = errno == ENOENT;  // there is nothing, to which one can go back
        forget(std::exchange(old, {}));
      }
    }
    if (::rename(temporary.c_str(), target.c_str()) != 0) {
      const int error = errno;
      if (!old.empty()) discard(old);
      return error;
    }
    forget(temporary);
    if (can_go_back) files_.push_back({target, old});
    return 0;
  }

  /// From here on nothing goes back.
  void settle() {
    for (const File& file : files_) {
      if (!file.old.empty()) discard(file.old);
    }
    files_.clear();
  }

 private:
  struct File {
    std::string target;
    std::string old;  // the second name of what was there; empty: nothing was
  };
  std::vector<File> files_;
};

void write_stream(const std::string& path, std::span<const std::byte> bytes) {
  Descriptor file(path == "-" ? STDOUT_FILENO : ::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (file.get() < 0) fail(path, "cannot be opened for writing", errno);
  const std::string name = path == "-" ? "standard output" : path;
  if (!write_all(file.get(), bytes)) fail(name, "cannot be written", errno);
  if (path != "-" && !file.close()) fail(name, "cannot be written", errno);
}

}  // namespace

std::vector<std::byte> read_file(const std::string& path) {
  const std::string name = path == "-" ? "standard input" : path;
  const Descriptor file(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) fail(name, "cannot be opened", errno);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) fail(name, "cannot be read", errno);

  // The size is a hint: pipes have none, and a file may grow while it is read.
  const size_t chunk = 1 << 16;
  std::vector<std::byte> bytes(size_t(S_ISREG(status.st_mode) ? status.st_size : 0) + chunk);
  size_t size = 0;
  for (;;) {
    if (size == bytes.size()) bytes.resize(2 * size);
    const ssize_t n = ::read(file.get(), bytes.data() + size, bytes.size() - size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(name, "cannot be read", errno);
    if (n == 0) break;
    size += size_t(n);
  }
  bytes.resize(size);
  return bytes;
}

void write_file(const std::string& path, std::span<const std::byte> bytes) {
  OutputSet outputs;
  outputs.add(path, bytes);
  outputs.commit();
}

void OutputSet::add(const std::string& path, std::span<const std::byte> bytes) {
  if (path.empty()) throw Error(Fault::Access, "an output file has no name: give one");
  const std::string target = path == "-" ? path : link_target(path);
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (path != "-" && fs::is_directory(status)) {
    throw Error(Fault::Access, path + ": is a folder: give the name of a file in it");
  }
  if (path == "-" || (fs::exists(status) && !fs::is_regular_file(status))) {
    streams_.push_back({target, {bytes.begin(), bytes.end()}});
    return;
  }
  // A file made read-only is not to be replaced, though a rename would do so.
  if (fs::exists(status) && ::access(target.c_str(), W_OK) != 0) fail(path, "cannot be written", errno);

  const std::string temporary = random_name(fs::path(target).parent_path());
  remember(temporary);
  staged_.push_back({path, target, temporary});
  Descriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (file.get() < 0) {
    const int reason = errno;
    forget(temporary);  // not ours: do not unlink it
    staged_.pop_back();
    fail(path, "cannot be written", reason);
  }
  if (!write_all(file.get(), bytes) || ::fsync(file.get()) != 0 || !file.close()) {
    fail(path, "cannot be written", errno);
  }
}

void OutputSet::commit() {
  for (const Stream& stream : streams_) write_stream(stream.path, stream.bytes);
  streams_.clear();
  Replacements replacements;
  for (const Staged& file : staged_) {
    const bool is_last = &file == &staged_.back();
    const int error = replacements.replace(file.target, file.temporary, !is_last);
    if (error != 0) fail(file.path, "cannot be written", error);
  }
  replacements.settle();
  staged_.clear();
}

OutputSet::~OutputSet() {
  for (const Staged& file : staged_) discard(file.temporary);
}

void remove_unfinished_files() noexcept {
  for (auto& slot : unfinished) {
    // The name is not freed: free() may not be called here.
    if (const char* name = slot.exchange(nullptr)) ::unlink(name);
  }
}

}  // namespace skinlod
