// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/chain.h"

namespace skinlod {

/// A way of making levels that the bench compares.
struct Method {
  std::string name;
  std::optional<Metric> metric;  // none: meshopt_simplify, which keeps the source's own weights
  int cap = 4;                   // on influences; 0: none
  WeightRule weights = WeightRule::NonNegative;
  int refine = 0;            // rounds after the collapse
  bool attributes = true;    // solved for; false: blended along
  bool byte_weights = true;  // as they are stored; false: as they were found
};

/// The default first.
const std::vector<Method>& methods();
std::vector<std::string> method_names();
const Method& method(const std::string& name);

/// A surface for each of `triangles`, which descend: at most so many, or as few as the method can do.
std::vector<Surface> make_levels(const Method& method, const Character& character,
                                 std::span<const Pose> examples, std::span<const int> triangles);

}  // namespace skinlod
