// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <span>
#include <tuple>

#include "pipeline/character.h"
#include "pipeline/warning.h"

namespace skinlod {

/// Counts what a step over a surface finds, item by item, and tells it by code and then by part.
class Findings {
 public:
  explicit Findings(std::span<const Part> parts) : parts_(parts) {}

  /// One item of `part`, an index or -1 where none is known.
  void note(WarningCode code, int part, std::string_view detail) { ++count_[{code, part, detail}]; }

  Warnings warnings() const {
    Warnings all;
    for (const auto& [key, count] : count_) {
      const auto& [code, part, detail] = key;
      warn(all, {code, part < 0 ? "" : parts_[size_t(part)].name, count, std::string(detail)});
    }
    return all;
  }

 private:
  std::span<const Part> parts_;
  std::map<std::tuple<WarningCode, int, std::string_view>, std::int64_t> count_;  // details are literals
};

}  // namespace skinlod
