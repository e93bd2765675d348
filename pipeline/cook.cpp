// SPDX-License-Identifier: MIT
#include "pipeline/cook.h"

#include "pipeline/repair.h"

namespace skinlod {

Cooked cook(Character imported, const CookOptions& options, const Progress& progress) {
  const auto stage = [&](std::string_view name) {
    if (progress) progress(name, 0);
  };
  Cooked cooked{.character = std::move(imported), .poses = {}, .chain = {}, .baselines = {}, .warnings = {}};
  stage("repairing");
  cooked.warnings = repair(cooked.character);
  if (options.merge_materials) merge_materials(cooked.character);
  if (options.chain.morphs == MorphUse::None) remove_morphs(cooked.character);
  for (Warning& warning : weld(cooked.character)) warn(cooked.warnings, std::move(warning));
  stage("choosing poses");
  cooked.poses = choose_poses(cooked.character, options.poses);
  cooked.chain = build_chain(cooked.character, cooked.poses, options.chain, progress);
  if (!options.baselines.empty()) {
    stage("baselines");
    cooked.baselines =
        measure_baselines(cooked.character, cooked.poses, cooked.chain.levels, options.baselines);
  }
  return cooked;
}

}  // namespace skinlod
