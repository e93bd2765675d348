// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "pipeline/error.h"
#include "tests/shapes.h"
#include "tools/run.h"

/// The program in a test's hands: `skinlod(...)` is a whole run, in-process, with an importer that makes
/// `test:tube` and its like by formula.
namespace skinlod {

/// A folder of the test's own, gone with it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "skinlod-test-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

  /// The names of all that stands in it, folders ending in a slash.
  std::set<std::string> names() const {
    std::set<std::string> all;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path_)) {
      all.insert(entry.path().lexically_relative(path_).string() + (entry.is_directory() ? "/" : ""));
    }
    return all;
  }

 private:
  std::filesystem::path path_;
};

inline std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void put(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// A tube with clips of a few frames: most of a cook's time goes into measuring poses.
inline Character test_tube() {
  Character tube = bending_tube(12, 24, 4);
  for (Clip& clip : tube.clips) {
    for (Channel& channel : clip.channels) {
      for (double& time : channel.times) time /= 4;
    }
  }
  return tube;
}

/// Gives the tube three targets: "bulge", which swells it and which the clip "bend" turns on, "twitch", which
/// moves one side by 2 mm, and "still", which moves nothing.
inline void add_morphs(Character& tube) {
  const int node = tube.parts[0].node;
  tube.morphs = {{"bulge", node}, {"twitch", node}, {"still", node}};
  for (const Vec3& x : tube.surface.position) {
    MorphOffsets& offsets = tube.surface.morphs.emplace_back();
    if (x.y() > 1 && x.y() < 3) offsets.push_back({0, 0.5 * Vec3(x.x(), 0, x.z())});
    if (x.x() > 0.5) offsets.push_back({1, Vec3(0, 0.002, 0)});
  }
  Clip& bend = tube.clips[0];
  Rows weights = Rows::Zero(2, 3);
  weights(1, 0) = 1;
  bend.channels.push_back({node, Path::MorphWeights, Interpolation::Linear, {0, bend.duration()}, weights});
}

/// test:tube has nothing to warn of; test:smile is the tube with morph targets; test:heavy has a vertex whose
/// weights sum to 2; test:still has no clips; test:lower and test:upper are the tube in two halves.
inline Imported test_character(const std::string& path) {
  if (!path.starts_with("test:")) return import_character(path);
  Imported imported;
  imported.character = test_tube();
  imported.files_read = {path};
  const auto cut = [&](bool above) {
    imported.character = part_of(test_tube(), [above](const Vec3& x) { return (x.y() > 2) == above; });
  };
  if (path == "test:lower" || path == "test:upper") cut(path == "test:upper");
  if (path == "test:smile") add_morphs(imported.character);
  if (path == "test:still") imported.character.clips.clear();
  if (path == "test:heavy") {
    for (Influence& influence : imported.character.surface.influences[0]) influence.weight *= 2;
  }
  return imported;
}

/// test:wave is a clip of which three of four channels bind.
inline BoundClips test_clips(const std::string& path, const Skeleton& skeleton) {
  if (!path.starts_with("test:")) return import_clips(path, skeleton);
  BoundClips bound;
  bound.clips = {test_tube().clips[0]};  // "bend", a name that the tube has taken
  bound.channels = 4, bound.bound = 3;
  bound.files_read = {path};
  return bound;
}

struct Outcome {
  int code = -1;  // the exit code
  std::string out, err;
};

inline Outcome skinlod(const std::vector<std::string>& args) {
  std::ostringstream out, err;
  Outcome outcome;
  try {
    outcome.code = run(args, out, err, {test_character, test_clips});
  } catch (const Error& e) {
    outcome.code = int(e.fault);
    err << "skinlod: " << e.what() << '\n';  // as main does
  }
  outcome.out = out.str(), outcome.err = err.str();
  return outcome;
}

}  // namespace skinlod
