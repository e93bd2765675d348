// SPDX-License-Identifier: MIT
#include <limits>
#include <ostream>

#include "formats/file.h"
#include "formats/slod.h"
#include "pipeline/error.h"
#include "pipeline/parallel.h"
#include "pipeline/repair.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/evaluation.h"
#include "tools/progress.h"

namespace skinlod {
namespace {

struct EvaluateArguments {
  std::string original;
  std::vector<std::string> candidates, clips;
  PoseOptions poses{.from_clips = 0, .range_of_motion = 0, .unseen_clip_frames = 40};
  DeviationOptions deviation{.samples = 20000, .attributes = true};
  int threads = 0;
  bool json = false, csv = false, quiet = false;
};

bool parse(EvaluateArguments& a, std::span<const std::string> args, std::ostream& out) {
  CommandLine line(
      "evaluate", "ORIGINAL CANDIDATE... [options]",
      "Measures how far candidates lie from the original when both move: the levels of a .slod, or\n"
      "characters by anyone, whose joints are matched by name. Both ways, in every pose.");
  line.input("ORIGINAL", a.original, "the character as it was made; - is stdin (GLB)");
  line.inputs("CANDIDATE", a.candidates, "a .slod, or a character in any format that is read; one or more");
  line.group("Poses");
  line.words("--clips", "FILE", a.clips,
             "more clips, bound to the original's joints by name; may be repeated");
  line.number("--frames", "COUNT", a.poses.unseen_clip_frames, 0, 10000, "frames of the clips");
  line.number("--rom", "COUNT", a.poses.unseen_range_of_motion, 0, 10000,
              "poses made from the joints' ranges of motion");
  line.number("--targets", "COUNT", a.poses.morphs, 0, 10000,
              "morph targets, those with the largest offsets, each at weight 1 at rest");
  line.number("--seed", "NUMBER", a.poses.seed, 0, std::numeric_limits<std::uint32_t>::max(),
              "of the range-of-motion poses");
  line.group("Measuring");
  line.number("--samples", "COUNT", a.deviation.samples, 1, 100000000, "points on each surface in each pose");
  line.group("Running");
  line.number("--threads", "COUNT", a.threads, 0, 1024,
              "threads to use, 0 for all; the result does not depend on it");
  line.flag("--json", a.json, "all of it as JSON on stdout: see report.schema.json");
  line.flag("--csv", a.csv, "a line per level and pose as CSV on stdout");
  line.flag("-q,--quiet", a.quiet, "no warnings, no progress");
  line.footer(
      "Errors are in % of the diagonal of the rest pose and in mm; the maximum is one that no point "
      "exceeds.\n\n"
      "Examples:\n"
      "  skinlod evaluate hero.glb hero.slod\n"
      "  skinlod evaluate hero.fbx hero.slod other_tool.glb --clips run.fbx --frames 100\n"
      "  skinlod evaluate hero.glb lods/hero_lod*.glb --csv > hero.csv\n");
  if (!line.parse(args, out)) return false;
  if (a.json && a.csv) throw Error{Fault::Usage, "--json: contradicts --csv: give one of them"};
  return true;
}

Imported read_repaired(const InputFile& file, const std::vector<std::string>& clips, const Console& console,
                       Evaluation& evaluation) {
  Imported read = file.character(console.readers);
  if (!clips.empty()) evaluation.clip_files = add_clips(read, clips, console.readers);
  for (Warning& w : repair(read.character)) warn(read.warnings, std::move(w));
  return read;
}

void add_candidate(Evaluation& evaluation, const std::string& path, const Console& console) {
  const InputFile file(path);
  if (!file.is_slod()) {
    Character character = read_repaired(file, {}, console, evaluation).character;
    evaluation.candidates.push_back(
        {file.name(), -1, match(evaluation.original, character, std::move(character.surface), file.name())});
    return;
  }
  SlodFile slod = read_slod(read_file(file.path()), file.name());
  for (size_t l = 0; l < slod.levels.size(); ++l) {
    const std::string name = file.name() + ": LOD" + std::to_string(l);
    evaluation.candidates.push_back(
        {file.name(), int(l),
         match(evaluation.original, slod.character, std::move(slod.levels[l].surface), name)});
  }
}

}  // namespace

int evaluate_command(std::span<const std::string> args, const Console& console) {
  EvaluateArguments a;
  if (!parse(a, args, console.out)) return 0;
  const ThreadLimit threads(a.threads);
  ProgressBar bar(console.err, !a.quiet && is_terminal(console.err));

  Evaluation evaluation{.options = a.deviation};
  bar("reading", 0);
  const InputFile input(a.original);
  if (input.is_slod()) {
    throw Error{Fault::Input,
                input.name() + ": is a .slod, which is no original: give the source it was made of"};
  }
  Imported original = read_repaired(input, a.clips, console, evaluation);
  evaluation.input = input.name();
  evaluation.warnings = std::move(original.warnings);
  evaluation.original = std::move(original.character);
  evaluation.original.surface = triangulated(evaluation.original.surface);
  for (const std::string& path : a.candidates) add_candidate(evaluation, path, console);
  bar("choosing poses", 0);
  evaluation.poses = choose_poses(evaluation.original, a.poses);
  bar("measuring", 0);
  const Json told = report(evaluation);
  bar.clear();
  if (!a.quiet) {
    for (const Warning& warning : evaluation.warnings)
      console.err << "skinlod: warning: " << text(warning) << '\n';
  }
  if (a.json) {
    console.out << text(told);
  } else if (a.csv) {
    print_csv(console.out, told);
  } else {
    print_evaluation(console.out, told);
  }
  return 0;
}

}  // namespace skinlod
