// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/slod.h"
#include "pipeline/cook.h"
#include "pipeline/pack.h"
#include "tools/input.h"

/// The machine-readable results: `--report FILE` and `--json`. Their form is report.schema.json beside this
/// file; "version" goes up when a reader of the old form could be misled, not when keys are added. Lengths
/// are metres, percentages are of the diagonal of the rest pose, and no time, path, host or thread count
/// stands in them: the same cook gives the same report.
namespace skinlod {

using Json = nlohmann::ordered_json;

/// What a cook's report tells.
struct CookStory {
  std::string input{};  // a name without folders
  std::vector<ClipFile> clip_files{};
  CookOptions options;
  PackOptions pack;
  Warnings warnings{};  // of all stages
  Cooked cooked{};
  std::vector<std::string> target{};       // per level, as it was asked for; "source" for level 0
  std::vector<std::size_t> level_bytes{};  // per level
  std::size_t bytes = 0;                   // of the .slod
  std::vector<std::string> glb{};          // per level, a name without folders; or empty: none written
};
Json report(const CookStory& story);

/// What `skinlod inspect` tells of a source.
struct SourceStory {
  std::string input;
  int imported_vertices = 0;
  Character character;  // repaired and welded
  Warnings warnings;
};
Json report(const SourceStory& story);

/// What `skinlod inspect` tells of a .slod.
struct SlodStory {
  std::string input;
  std::vector<std::byte> bytes;
  SlodFile file;  // read from the bytes
};
Json report(const SlodStory& story);

/// What `skinlod formats` tells.
Json report(const std::vector<Format>& formats);

/// What every report begins with, `input` being a name without folders.
Json report_head(const char* kind);
Json report_head(const char* kind, const std::string& input);

Json warnings_report(const Warnings& all);

/// The four figures of an error in metres and in percent of `diagonal`.
Json error_report(const PosedError& error, double diagonal);

/// Two blanks deep, with a line break at the end; names that are no UTF-8 are mended.
std::string text(const Json& report);

/// How many vertices have 0, 1, 2... influences.
std::vector<int> influence_histogram(const Surface& surface);

/// The largest number of influences of a vertex.
int most_influences(const Surface& surface);

}  // namespace skinlod
