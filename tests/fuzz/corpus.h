// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace skinlod::fuzz {

/// The stored inputs of a fuzzer by name: what it needed to reach all that it has reached, and what it has
/// found. Throws where there are none.
inline std::map<std::string, std::vector<std::uint8_t>> corpus(const std::string& fuzzer) {
  std::map<std::string, std::vector<std::uint8_t>> inputs;
  for (const auto& entry : std::filesystem::directory_iterator("tests/fuzz/corpus/" + fuzzer)) {
    std::ifstream file(entry.path(), std::ios::binary);
    inputs[entry.path().filename()] = {std::istreambuf_iterator<char>(file), {}};
  }
  if (inputs.empty()) throw std::runtime_error("no stored inputs for " + fuzzer);
  return inputs;
}

}  // namespace skinlod::fuzz
