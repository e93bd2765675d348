// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/evaluate.h"
#include "pipeline/history.h"
#include "pipeline/importance.h"
#include "pipeline/influences.h"
#include "pipeline/joint_lod.h"
#include "pipeline/morphs.h"

namespace skinlod {

/// What a level is to be. Exactly one of `ratio`, `triangles` and `max_error` is present.
struct LevelTarget {
  std::optional<double> ratio{};   // of the source's triangles, in (0, 1]
  std::optional<int> triangles{};  // at most so many
  std::optional<double>
      max_error{};         // the fewest triangles whose RMS posed error stays below, metres / diagonal
  int max_influences = 4;  // 1 to 8; 0: no limit, for comparison: such a level cannot be packed
  /// How many joints its vertices may follow; or what all joints that have left may have cost together, RMS
  /// metres / diagonal. At most one of the two, for Metric::Articulated alone.
  std::optional<int> max_joints{};
  std::optional<double> joint_error{};
};

/// More rounds of fitting than this gain nothing.
inline constexpr int kMaxRefineRounds = 3;

/// Which metric decides what to collapse and where the point goes; each has its file in metrics/.
enum class Metric { Articulated, PoseIndependent, Endpoint, RestPose };

/// What users call them, in that order.
inline constexpr std::array<const char*, 4> kMetricNames = {"articulated", "pose_independent", "endpoint",
                                                            "rest_pose"};

/// One finished level of detail and what is known of it.
struct Level {
  std::size_t steps = 0;   // of the history, from the source to here
  Surface surface;         // triangles
  int max_influences = 4;  // the cap that holds at every vertex; 0: none
  int asked = 0;           // triangles asked for; for an error target those it came to
  bool reached = true;     // false: more triangles or joints than asked, and `reason` says why
  std::string reason{};
  PosedError examples{};       // over the example poses
  PosedError unseen_clip{};    // over clip frames not used for solving
  PosedError unseen_motion{};  // over range-of-motion poses not used for solving
  PosedError morphs{};         // over the morph targets, one at a time
  /// How many joints vertices follow, and which have left since the level before, in that order.
  int joints = 0;
  std::vector<LeftJoint> joints_left{};
};

/// Called with the stage's name and the fraction of it that is done, 0 to 1, from the calling thread.
using Progress = std::function<void(std::string_view stage, double fraction)>;

struct ChainOptions {
  std::vector<LevelTarget> targets;
  Metric metric = Metric::Articulated;
  WeightRule weights = WeightRule::NonNegative;  // Signed: Articulated alone; such levels cannot be packed
  std::vector<std::string> keep_joints{};        // patterns of joints that must not leave: see kept_joints.h
  std::vector<Importance> importance{};          // where errors count more or less than elsewhere
  bool source_level = true;                      // level 0 is the source itself, under the first target's cap
  Borders borders = Borders::Free;               // locked: open borders are the source's in every level
  int refine = 1;                                // rounds of fitting levels to the source: Articulated alone
  bool attributes = true;            // false, for comparison: normals, uvs and colours are only blended along
  MorphUse morphs = MorphUse::Keep;  // which targets the levels have
  bool byte_weights = true;          // fitting ends with weights as they are stored, in 255ths; Signed never
  bool measured = true;              // find the levels' errors, which else are 0
};

/// What the collapse found out. The levels are readings of the history, fitted to the source after that.
struct Chain {
  History history;
  std::vector<Level> levels;  // finest first
};

/// The levels of a repaired, welded character, each with its measured errors.
/// Throws Error{Usage} where the options make no sense.
Chain build_chain(const Character& character, const PoseSet& poses, const ChainOptions& options,
                  const Progress& progress = {});

}  // namespace skinlod
