// SPDX-License-Identifier: MIT
#include "tests/bench/method.h"

#include <algorithm>

#include "pipeline/baseline.h"
#include "pipeline/error.h"

namespace skinlod {

const std::vector<Method>& methods() {
  static const std::vector<Method> all = {
      {"refined", Metric::Articulated, 4, WeightRule::NonNegative, ChainOptions{}.refine},
      {"refined_blind", Metric::Articulated, 4, WeightRule::NonNegative, ChainOptions{}.refine, false},
      {"refined_float", Metric::Articulated, 4, WeightRule::NonNegative, ChainOptions{}.refine, true, false},
      {"articulated", Metric::Articulated},
      {"articulated_uncapped", Metric::Articulated, 0},
      {"articulated_signed", Metric::Articulated, 4, WeightRule::Signed},
      {"pose_independent", Metric::PoseIndependent},
      {"endpoint", Metric::Endpoint},
      {"rest_pose", Metric::RestPose},
      {"meshopt_simplify", std::nullopt},
  };
  return all;
}

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const Method& m : methods()) names.push_back(m.name);
  return names;
}

const Method& method(const std::string& name) {
  const auto& all = methods();
  const auto at = std::find_if(all.begin(), all.end(), [&](const Method& m) { return m.name == name; });
  if (at == all.end()) throw Error{Fault::Ours, "method: '" + name + "' is none"};
  return *at;
}

std::vector<Surface> make_levels(const Method& method, const Character& character,
                                 std::span<const Pose> examples, std::span<const int> triangles) {
  std::vector<Surface> levels;
  if (!method.metric) {
    for (const int count : triangles) levels.push_back(meshopt_level(character.surface, count));
    return levels;
  }
  ChainOptions options{.targets = {},
                       .metric = *method.metric,
                       .weights = method.weights,
                       .source_level = false,
                       .refine = method.refine,
                       .attributes = method.attributes,
                       .byte_weights = method.byte_weights,
                       .measured = false};
  for (const int count : triangles)
    options.targets.push_back({.triangles = count, .max_influences = method.cap});
  PoseSet poses;
  poses.examples.assign(examples.begin(), examples.end());
  Chain chain = build_chain(character, poses, options);
  for (Level& level : chain.levels) levels.push_back(std::move(level.surface));
  return levels;
}

}  // namespace skinlod
