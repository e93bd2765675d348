// SPDX-License-Identifier: MIT
#include "tools/lod_table.h"

#include <ostream>

#include "tools/table.h"

namespace skinlod {
namespace {

using Row = std::vector<std::string>;

// Columns for morphs are there only where the character has some.
void add_errors(Row& row, const Level& level, const PoseSet& poses, double scale) {
  const auto add = [&](const PosedError& error, bool measured) {
    row.push_back(measured ? rounded(error.rms * scale) : "-");
    row.push_back(measured ? rounded(error.max * scale) : "-");
  };
  add(level.examples, !poses.examples.empty());
  add(level.unseen_clip, !poses.unseen_clip.empty());
  add(level.unseen_motion, !poses.unseen_motion.empty());
  if (!poses.morphs.empty()) add(level.morphs, true);
}

std::string lod_name(const CookStory& story, size_t level) {
  return "LOD" + std::to_string(level + (story.options.chain.source_level ? 0 : 1));
}

// RMS errors alone, and how many times the level's own they are.
void print_baselines(std::ostream& out, const CookStory& story) {
  const auto& [character, poses, chain, baselines, repairs] = story.cooked;
  const double size = diagonal(character.surface.position), to_percent = size > 0 ? 100 / size : 0;
  std::vector<Row> rows = {{"", "", "", "unseen", "clips", "range of", "motion"},
                           {"level", "baseline", "triangles", "RMS %", "of ours", "RMS %", "of ours"}};
  for (size_t i = 0; i < chain.levels.size(); ++i) {
    const Level& level = chain.levels[i];
    for (size_t b = 0; b < baselines.size() && level.steps > 0; ++b) {
      const BaselineLevel& its = baselines[b][i];
      Row& row = rows.emplace_back(Row{lod_name(story, i), kBaselineNames[size_t(story.options.baselines[b])],
                                       grouped(its.triangles)});
      const auto add = [&](const PosedError& error, const PosedError& ours, bool measured) {
        row.push_back(measured ? rounded(error.rms * to_percent) : "-");
        row.push_back(measured && ours.rms > 0 ? "x " + rounded(error.rms / ours.rms) : "-");
      };
      add(its.unseen_clip, level.unseen_clip, !poses.unseen_clip.empty());
      add(its.unseen_motion, level.unseen_motion, !poses.unseen_motion.empty());
    }
  }
  out << '\n';
  print_table(out, rows);
}

}  // namespace

void print_lod_table(std::ostream& out, const CookStory& story) {
  const auto& [character, poses, chain, baselines, repairs] = story.cooked;
  const Surface& s = character.surface;
  const double size = diagonal(s.position);
  const int triangles = triangle_count(s);

  out << story.input << ": " << grouped(triangles) << " triangles, "
      << grouped(std::int64_t(s.position.size())) << " vertices, " << character.skeleton.joints.size()
      << " joints, up to " << most_influences(s) << " influences, diagonal " << rounded(size) << " m\n";
  for (const ClipFile& file : story.clip_files) {
    out << file.name << ": " << file.bound << " of " << file.channels << " channels bound, "
        << file.clips.size() << (file.clips.size() == 1 ? " clip\n" : " clips\n");
  }
  out << poses.examples.size() << " example poses; unseen: " << poses.unseen_clip.size() << " clip frames, "
      << poses.unseen_motion.size() << " range-of-motion poses";
  if (!poses.morphs.empty())
    out << "; " << poses.morphs.size() << " of " << character.morphs.size() << " morph targets";
  out << "\n\n";

  std::vector<Row> rows = {{"", "", "of", "", "", "infl.", "", "posed", "example", "poses", "unseen", "clips",
                            "range of", "motion"},
                           {"level", "triangles", "source", "vertices", "joints", "(cap)", "bytes", "error",
                            "RMS", "max", "RMS", "max", "RMS", "max"}};
  if (!poses.morphs.empty()) {
    rows[0].insert(rows[0].end(), {"", "morphs"});
    rows[1].insert(rows[1].end(), {"RMS", "max"});
  }
  for (size_t i = 0; i < chain.levels.size(); ++i) {
    const Level& level = chain.levels[i];
    const int n = triangle_count(level.surface);
    Row& percent = rows.emplace_back(Row{
        lod_name(story, i), grouped(n), rounded(triangles > 0 ? 100.0 * n / triangles : 0) + " %",
        grouped(std::int64_t(level.surface.position.size())), std::to_string(level.joints),
        std::to_string(most_influences(level.surface)) + " (" + std::to_string(level.max_influences) + ")",
        grouped(std::int64_t(story.level_bytes[i])), "%"});
    add_errors(percent, level, poses, size > 0 ? 100 / size : 0);
    Row& millimetres = rows.emplace_back(Row{"", "", "", "", "", "", "", "mm"});
    add_errors(millimetres, level, poses, 1000);
  }
  print_table(out, rows);
  if (!baselines.empty()) print_baselines(out, story);
}

}  // namespace skinlod
