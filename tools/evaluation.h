// SPDX-License-Identifier: MIT
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "pipeline/evaluate.h"
#include "pipeline/match.h"
#include "tools/input.h"
#include "tools/report.h"

/// What `skinlod evaluate` measures and tells.
namespace skinlod {

/// One surface that is compared with the original.
struct Candidate {
  std::string file;  // a name without folders
  int lod = -1;      // of a .slod, else -1
  Matched matched;
};

struct Evaluation {
  std::string input{};  // a name without folders
  std::vector<ClipFile> clip_files{};
  Warnings warnings{};
  Character original{};  // repaired, of triangles
  PoseSet poses{};       // the bind pose in `examples`; what is measured in `unseen_clip` and `unseen_motion`
  DeviationOptions options{};
  std::vector<Candidate> candidates{};
};

/// Measures every candidate. What people and spreadsheets get is written from this report.
Json report(const Evaluation& evaluation);
void print_evaluation(std::ostream& out, const Json& told);

/// A line per candidate and pose, a title line first; lengths in metres, angles in degrees.
void print_csv(std::ostream& out, const Json& told);

}  // namespace skinlod
