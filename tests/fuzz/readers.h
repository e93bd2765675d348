// SPDX-License-Identifier: MIT
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "formats/archive.h"
#include "formats/gltf.h"
#include "formats/slod.h"
#include "pipeline/error.h"
#include "pipeline/repair.h"

/// Hostile bytes through the readers of files. Shared by libFuzzer and by the tests of truncation and bit
/// flips.
namespace skinlod::fuzz {

inline void require(bool is_so, const char* fact) {
  if (!is_so) throw std::logic_error(fact);  // ends a fuzzer, and fails a test
}

/// What `action` gives, or false where it refuses its input as it should: with an Error of the input's.
template <class Action>
bool done_or_refused(const Action& action) {
  try {
    return action();
  } catch (const Error& e) {
    require(e.fault == Fault::Input || e.fault == Fault::Access, e.what());
    return false;
  }
}

/// Whether every index in the surface names something that is there.
inline void check_indices(const Character& c, const Surface& s) {
  require(s.influences.size() == s.position.size(), "influences for each vertex");
  require(size_t(s.attributes.rows()) == s.wedges.size(), "attributes for each wedge");
  require(s.morphs.empty() || s.morphs.size() == s.position.size(), "morphs for each vertex");
  for (const Wedge& wedge : s.wedges) {
    require(wedge.vertex >= 0 && size_t(wedge.vertex) < s.position.size(), "the vertex of a wedge");
    require(wedge.part >= 0 && size_t(wedge.part) < c.parts.size(), "the part of a wedge");
  }
  for (const Influences& influences : s.influences) {
    for (const Influence& i : influences) {
      require(i.joint >= 0 && size_t(i.joint) < c.skeleton.joints.size(), "the joint of an influence");
    }
  }
  for (const int wedge : s.corners) {
    require(wedge >= 0 && size_t(wedge) < s.wedges.size(), "the wedge of a corner");
  }
}

/// True where the bytes are a .slod whose parts fit together, false where they are refused.
inline bool read_as_slod(std::span<const std::uint8_t> bytes) {
  return done_or_refused([&] {
    const SlodFile file = read_slod(std::as_bytes(bytes), "hostile.slod");
    for (const SlodLevel& level : file.levels) check_indices(file.character, level.surface);
    return true;
  });
}

/// Repairs what was read and writes it.
inline void use(Imported& imported) {
  Character& c = imported.character;
  done_or_refused([&] {
    repair(c);
    check_indices(c, c.surface);
    return !write_glb(c, c.surface, imported.document.get()).empty();
  });
}

/// True where the bytes are what comes back from the process that reads for us, false where they are refused.
inline bool read_as_archive(std::span<const std::uint8_t> bytes) {
  return done_or_refused([&] {
    Imported imported = from_bytes(std::as_bytes(bytes));
    use(imported);
    return true;
  });
}

/// True where the bytes are a glTF character, which is then repaired and written, false where they are
/// refused.
inline bool read_as_gltf(std::span<const std::uint8_t> bytes) {
  struct UnnamedFile {  // importers read by path
    int fd = memfd_create("skinlod-fuzz", MFD_CLOEXEC);
    ~UnnamedFile() { close(fd); }
  } file;
  require(write(file.fd, bytes.data(), bytes.size()) == ssize_t(bytes.size()), "no room for the file");
  Imported imported;
  const bool is_read = done_or_refused([&] {
    imported = import_gltf("/proc/self/fd/" + std::to_string(file.fd));
    return true;
  });
  if (!is_read) return false;
  const Surface& s = imported.character.surface;
  require(s.wedges.size() == s.position.size(), "a wedge for each vertex");
  for (const int wedge : s.corners) require(wedge < int(s.wedges.size()), "a wedge");
  use(imported);
  return true;
}

}  // namespace skinlod::fuzz
