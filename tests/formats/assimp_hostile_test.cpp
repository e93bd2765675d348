// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cstdint>
#include <map>
#include <random>
#include <stdexcept>

#include "formats/assimp.h"
#include "formats/isolate.h"
#include "pipeline/error.h"
#include "tests/formats/scratch.h"
#include "tests/formats/small_files.h"
#include "tests/fuzz/corpus.h"
#include "tests/fuzz/readers.h"  // what libFuzzer runs

namespace skinlod {
namespace {

constexpr std::uint64_t kAssimpMemory = std::uint64_t(256) << 20;

using Files = std::map<std::string, std::string>;  // by name

/// A small character in every format that Assimp reads for us, with the files that stand beside it.
Files small_files() {
  Files files = {{"small.md5mesh", kSmallMd5}, {"small.dae", kSmallCollada}, {"small.x", kClashingX}};
  for (const auto& [name, bytes] : fuzz::corpus("assimp")) {
    if (name.starts_with("small.")) files[name] = {bytes.begin(), bytes.end()};
  }
  return files;
}

/// The character file that a file belongs to: itself, or the mesh of a skeleton.
std::string mesh_of(const std::string& name) {
  const size_t skeleton = name.find(".skeleton");
  return skeleton == name.npos ? name : name.substr(0, skeleton) + ".mesh" + name.substr(skeleton + 9);
}

struct Ending {
  int fault = 0;
  std::string message{};
};

/// What becomes of a file among `files` in little memory, the reader's own limits within.
Ending outcome(const Files& files, const std::string& name) {
  const Scratch folder;
  for (const auto& [its, text] : files) folder.file(its, text);
  try {
    run_isolated(name, {.cpu_seconds = 20, .memory_bytes = kAssimpMemory}, [&] {
      Imported imported = import_assimp(folder.file(mesh_of(name)));
      try {
        fuzz::use(imported);
      } catch (const std::logic_error& e) {  // otherwise it would pass for a refusal
        throw Error(Fault::Ours, e.what());
      }
      return std::vector<std::byte>(1);
    });
  } catch (const Error& e) {
    return {int(e.fault), e.what()};
  }
  return {};
}

bool is_read_or_refused(const Ending& outcome) {
  return outcome.fault == 0 || outcome.fault == int(Fault::Input);
}

}  // namespace

TEST_SUITE("assimp_hostile") {
  TEST_CASE("the small files are whole and those that crash Assimp are refused") {
    for (const auto& [name, text] : small_files()) {
      const auto& input = name;  // clang 14 captures no structured binding
      CAPTURE(input);
      const Ending small = outcome(small_files(), name);
      CAPTURE(small.message);
      CHECK(small.fault == 0);
    }
    int crashes = 0;
    for (const auto& [name, bytes] : fuzz::corpus("assimp")) {
      if (name.starts_with("small.") || mesh_of(name) != name) continue;
      const auto& input = name;  // clang 14 captures no structured binding
      CAPTURE(input);
      const Scratch folder;
      std::filesystem::copy("tests/fuzz/corpus/assimp", folder.file("all"));
      try {
        import_assimp(folder.file("all") + "/" + name);
        FAIL("it was read");
      } catch (const Error& e) {
        CHECK(e.fault == Fault::Input);
        crashes += std::string(e.what()).find(": its reader ") != std::string::npos;
      }
    }
    CHECK(crashes > 0);
  }

  TEST_CASE("cuts and flipped bits of every format end in a character or a refusal") {
    const Files whole = small_files();
    for (const auto& [name, text] : whole) {
      const auto& input = name;  // clang 14 captures no structured binding
      CAPTURE(input);
      int refused = 0;
      for (std::uint32_t seed = 0; seed < 40; ++seed) {
        CAPTURE(seed);
        std::mt19937 random(seed);
        Files files = whole;
        std::string& bad = files[name];
        if (seed % 2 == 0) {
          bad.resize(bad.size() * (seed + 1) / 41);
        } else {
          for (auto flips = 1 + random() % 8; flips > 0; --flips)
            bad[random() % bad.size()] ^= char(1u << random() % 8);
        }
        const Ending its = outcome(files, name);
        CAPTURE(its.message);
        CHECK(is_read_or_refused(its));
        refused += its.fault != 0;
      }
      CHECK(refused > 5);
    }
  }

  TEST_CASE("lies about counts and sizes are refused in little memory") {
    struct Lie {
      std::string file, from, to;
    };
    const std::string huge("\xff\xff\xff\x7f", 4);
    const auto word = [](std::uint32_t value) {
      return std::string(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (const Lie& lie : {
             Lie{"small.md5mesh", "numverts 4", "numverts 2000000000"},
             Lie{"small.md5mesh", "numtris 2", "numtris 2000000000"},
             Lie{"small.md5mesh", "numweights 5", "numweights 2000000000"},
             Lie{"small.dae", "count=\"32\"", "count=\"4000000000\""},
             Lie{"small.dae", "<vcount>3</vcount>", "<vcount>2000000000</vcount>"},
             Lie{"small.dae", "<vcount>1 1 1 2</vcount>", "<vcount>1 1 1 2000000000</vcount>"},
             Lie{"small.fbx", "Vertices: *12", "Vertices: *2000000000"},
             Lie{"small.fbx", "a: 0,1,2,-4", "a: 0,1,2000000000,-4"},
             Lie{"small.b3d", "VRTS" + word(108), "VRTS" + huge},
             Lie{"small.b3d", "NODE", "NODE" + huge},
             Lie{"small.mesh", std::string("\x00\x50", 2), std::string("\x00\x50", 2) + huge},
             Lie{"small.mesh.xml", "vertexcount=\"4\"", "vertexcount=\"4000000000\""},
             Lie{"small.mesh.xml", "v1=\"0\"", "v1=\"2000000000\""},
             Lie{"small.skeleton.xml", "bone id=\"1\"", "bone id=\"60000\""},
         }) {
      CAPTURE(lie.file);
      CAPTURE(lie.from);
      Files files = small_files();
      files[lie.file] = edited(files[lie.file], lie.from, lie.to);
      REQUIRE(!files[lie.file].empty());
      const Ending its = outcome(files, lie.file);
      CHECK(its.fault == int(Fault::Input));
      CHECK(its.message.find(mesh_of(lie.file) + ": ") != std::string::npos);
    }
  }
}

TEST_SUITE("archive_hostile") {
  TEST_CASE("the fuzzer's stored inputs are read or refused") {
    for (const auto& [name, bytes] : fuzz::corpus("archive")) {
      const auto& input = name;  // clang 14 captures no structured binding
      CAPTURE(input);
      CHECK_NOTHROW(fuzz::read_as_archive(bytes));
    }
  }

  TEST_CASE("every word of an archive may lie") {
    const Scratch folder;
    const std::vector<std::byte> whole = to_bytes(import_assimp(folder.file("clash.x", kClashingX)));
    const std::vector<std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(whole.data()),
                                          reinterpret_cast<const std::uint8_t*>(whole.data()) + whole.size());
    REQUIRE(fuzz::read_as_archive(bytes));
    int refused = 0;
    run_isolated("archive", {.cpu_seconds = 60, .memory_bytes = kAssimpMemory}, [&] {
      for (size_t at = 0; at + 4 <= bytes.size(); ++at) {
        for (const std::uint32_t lie : {0xffffffffu, 0x7fffffffu, 0x00010000u, 0u}) {
          std::vector<std::uint8_t> lying = bytes;
          std::memcpy(&lying[at], &lie, sizeof lie);
          refused += !fuzz::read_as_archive(lying);
        }
      }
      if (refused == 0) throw std::logic_error("no lie was found");
      return std::vector<std::byte>(1);
    });
  }
}

}  // namespace skinlod
