// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>

namespace skinlod {

/// A folder for one test's files, gone with it.
class Scratch {
 public:
  Scratch() {
    std::string name = (std::filesystem::temp_directory_path() / "skinlod-test-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() { std::filesystem::remove_all(path_); }

  std::string file(const std::string& name) const { return path_ / name; }
  std::string file(const std::string& name, std::string_view text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  int count() const {
    return int(
        std::distance(std::filesystem::directory_iterator(path_), std::filesystem::directory_iterator()));
  }

 private:
  std::filesystem::path path_;
};

inline std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The path of a shared character's file, or nothing where the content is not on this machine.
inline std::optional<std::string> content(const std::string& file) {
  const char* folder = std::getenv("SKINLOD_CONTENT");
  const std::string path = std::string(folder ? folder : "../shared") + "/characters/" + file;
  if (std::filesystem::exists(path)) return path;
  return std::nullopt;
}

}  // namespace skinlod
