// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <limits>
#include <optional>
#include <ostream>
#include <sstream>

#include "formats/file.h"
#include "formats/gltf.h"
#include "formats/unite.h"
#include "pipeline/error.h"
#include "pipeline/parallel.h"
#include "pipeline/repair.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/depfile.h"
#include "tools/levels.h"
#include "tools/lod_table.h"
#include "tools/outputs.h"
#include "tools/progress.h"
#include "tools/report.h"
#include "tools/selections.h"
#include "tools/stage_clock.h"

namespace skinlod {
namespace {

namespace fs = std::filesystem;

/// The command line of `skinlod cook`. Defaults of the cook's own options are those of the pipeline.
struct CookArguments {
  std::string output, gltf_folder, report, depfile, timings;
  std::vector<std::string> inputs, clips, importance;
  std::string lods = "50%,25%,10%,5%";
  std::string max_error;  // given: takes the place of `lods`
  std::string max_influences = std::to_string(LevelTarget{}.max_influences);
  std::string max_joints, joint_error;
  CookOptions cook{};
  PackOptions pack{};
  int threads = 0;  // 0: all there are
  bool no_lod0 = false, lock_open_borders = false, no_compress = false, strict = false, json = false,
       quiet = false, verbose = false;
};

bool parse(CookArguments& a, std::span<const std::string> args, std::ostream& out) {
  CommandLine line(
      "cook", "INPUT... -o OUT.slod [options]",
      "Makes levels of detail of a rigged character that hold in motion: one .slod for the engine and,\n"
      "with --gltf, a GLB per level. On success the levels and their posed errors stand on stdout.\n"
      "Several inputs are the parts of one modular character, over one skeleton.");
  PoseOptions& poses = a.cook.poses;
  constexpr int kMost = 1000;
  line.group("Files");
  line.inputs("INPUT", a.inputs, "the character, or its parts: see skinlod formats; - is stdin (GLB)");
  line.word("-o,--output", "FILE", a.output, "the .slod to write; - is stdout");
  line.word("--gltf", "DIR", a.gltf_folder,
            "also write each level as DIR/NAME_lodK.glb, NAME from -o; DIR is made");
  line.words("--clips", "FILE", a.clips, "more clips, bound to the joints by name; may be repeated");
  line.word("--report", "FILE", a.report, "also write what was found and made as JSON; - is stdout");
  line.word("--depfile", "FILE", a.depfile,
            "also write a Makefile rule with all files read, for build systems");
  line.word("--timings", "FILE", a.timings,
            "also write seconds and peak memory of every stage as JSON: apart from the report, which never "
            "changes");
  line.group("Levels");
  line.word("--lods", "LIST", a.lods,
            "shares of the source's triangles (50%) or numbers of triangles (5000), fine to coarse");
  line.word(
      "--max-error", "LIST", a.max_error,
      "instead of --lods: per level the largest RMS posed error, % of the rest pose's diagonal (0.1%,0.5%)");
  line.word("--max-influences", "LIST", a.max_influences,
            "joints per vertex, 1 to 8: one cap, or one for each level (4,4,2,1)");
  line.word("--joints-per-lod", "LIST", a.max_joints,
            "joints that vertices may follow: one number, or one for each level (80,40,20,10); those whose "
            "absence costs least leave first, and none returns");
  line.word("--joint-error", "LIST", a.joint_error,
            "instead of --joints-per-lod: joints leave as long as all that left add at most this to the RMS "
            "posed error, % of the rest pose's diagonal: one, or one for each level (0.01%,0.05%)");
  line.words("--keep-joint", "PATTERN", a.cook.chain.keep_joints,
             "joints of this name must not leave, such as 'hand_*'; may be repeated. Joints with rigid props "
             "or attachments on them stay by themselves");
  line.words(
      "--importance", "PATTERN=FACTOR", a.importance,
      "distances count FACTOR times, 0.01 to 100, where vertices follow joints of this name (head*=4), "
      "have a material ('material:skin*=2'), or are painted in a channel (color:r=4); may be repeated, "
      "and factors multiply");
  line.choice("--morphs", a.cook.chain.morphs, {kMorphUseNames.begin(), kMorphUseNames.end()},
              "morph targets of a level: all that move anything there, those that move some vertex by more "
              "than the level is off at rest, or none");
  line.flag("--no-lod0", a.no_lod0, "leave out level 0, the source itself");
  line.flag(
      "--lock-open-borders", a.lock_open_borders,
      "vertices on open borders stay as they are in every level, so that parts cooked apart still meet");
  line.flag("--merge-materials", a.cook.merge_materials,
            "draw parts of one node and material together: fewer draw calls");
  line.group("Solving");
  line.choice("--metric", a.cook.chain.metric, {kMetricNames.begin(), kMetricNames.end()},
              "what decides: the error in all example poses; the others are older methods, to compare with");
  line.number("--refine", "ROUNDS", a.cook.chain.refine, 0, kMaxRefineRounds,
              "times that finished levels are fitted to the source in all example poses (articulated alone)");
  line.number("--poses", "COUNT", poses.from_clips, 0, kMost, "example poses chosen from the clips");
  line.number("--rom", "COUNT", poses.range_of_motion, 0, kMost,
              "example poses made from the joints' ranges of motion");
  line.words("--pose-clip", "NAME", poses.pose_clips,
             "a clip of which every key is an example pose; may be repeated");
  line.number("--seed", "NUMBER", poses.seed, 0, std::numeric_limits<std::uint32_t>::max(),
              "of the range-of-motion poses");
  line.choices("--baseline", a.cook.baselines, {kBaselineNames.begin(), kBaselineNames.end()},
               "also measure what these make of as many triangles, for the report: " +
                   line.joined({kBaselineNames.begin(), kBaselineNames.end()}));
  line.group("Running");
  line.flag("--strict", a.strict, "fail with exit code 3 on any warning, and write nothing");
  line.flag("--no-compress", a.no_compress,
            "store the .slod's streams raw, for loaders without meshoptimizer");
  line.number("--threads", "COUNT", a.threads, 0, 1024,
              "threads to use, 0 for all; the result does not depend on it");
  line.flag("--json", a.json, "the report on stdout, in place of the table");
  line.flag("-q,--quiet", a.quiet, "no table, no warnings, no progress");
  line.flag("-v,--verbose", a.verbose, "also list files read, poses, and what each stage took on stderr");
  line.footer(
      "Examples:\n"
      "  skinlod cook hero.glb -o hero.slod\n"
      "  skinlod cook hero.fbx --clips run.fbx --clips jump.fbx -o hero.slod --gltf lods\n"
      "  skinlod cook body.glb head.glb -o hero.slod\n"
      "  skinlod cook hero.glb -o hero.slod --lods 8000,3000,800 --max-influences 4,2,1\n"
      "  skinlod cook hero.glb -o hero.slod --max-error 0.05%,0.2%,1% --report hero.json\n");
  if (!line.parse(args, out)) return false;
  if (line.given("--lods") && line.given("--max-error")) {
    throw Error{Fault::Usage, "--max-error: contradicts --lods: give one of them"};
  }
  if (line.given("--joint-error") && line.given("--joints-per-lod")) {
    throw Error{Fault::Usage, "--joint-error: contradicts --joints-per-lod: give one of them"};
  }
  return true;
}

// What the options say about each other; what one says about itself is checked where it is read.
void validate(const CookArguments& a) {
  const auto refuse = [](const std::string& message) { throw Error{Fault::Usage, message}; };
  const fs::path output = a.output;
  for (size_t i = 1; i < a.inputs.size(); ++i) {
    const std::string& word = a.inputs[i];
    if (const auto meant = slip(word)) refuse(word + ": one word too many: " + *meant);
    if (std::count(a.inputs.begin(), a.inputs.end(), word) > 1)
      refuse(word + ": is given twice: give it once");
  }
  if (a.output.empty()) {
    const std::string stem = a.inputs[0] == "-" ? "hero" : fs::path(a.inputs[0]).stem().string();
    refuse("-o: missing: say where to write, -o " + stem + ".slod");
  }
  for (const char* other : {".glb", ".gltf", ".fbx", ".json"}) {
    if (output.extension() != other) continue;
    refuse("-o: " + a.output + ": would hold a .slod: write -o " + output.stem().string() + ".slod" +
           (other[1] == 'g' ? " --gltf DIR" : ""));
  }
  if ((a.output == "-") + (a.report == "-") + (a.depfile == "-") + (a.timings == "-") + a.json > 1) {
    refuse("stdout: can take one of -o, --report, --depfile, --timings and --json: give the others files");
  }
  if (a.output == "-" && !a.depfile.empty()) refuse("--depfile: needs an output with a name: give -o FILE");
  if (a.output == "-" && !a.gltf_folder.empty() && a.inputs[0] == "-") {
    refuse("--gltf: the levels need a name: give -o FILE");
  }
  const bool joints_leave = !a.max_joints.empty() || !a.joint_error.empty();
  if (joints_leave && a.cook.chain.metric != Metric::Articulated) {
    refuse(std::string(a.max_joints.empty() ? "--joint-error" : "--joints-per-lod") +
           ": needs --metric articulated: the others solve for no weights");
  }
  if (!joints_leave && !a.cook.chain.keep_joints.empty()) {
    refuse("--keep-joint: no joint would leave: give --joints-per-lod or --joint-error too");
  }
  if (a.quiet && a.verbose) refuse("--quiet: contradicts --verbose: give one of them");
}

std::vector<LevelTarget> level_targets(const CookArguments& a) {
  auto targets = a.max_error.empty() ? parse_lods(a.lods) : parse_max_errors(a.max_error);
  set_max_influences(targets, a.max_influences);
  if (!a.max_joints.empty()) set_max_joints(targets, a.max_joints);
  if (!a.joint_error.empty()) set_joint_errors(targets, a.joint_error);
  return targets;
}

std::vector<std::string> glb_names(const CookArguments& a) {
  if (a.gltf_folder.empty()) return {};
  const std::string stem = fs::path(a.output == "-" ? a.inputs[0] : a.output).stem().string();
  std::vector<std::string> names;
  for (size_t lod = a.no_lod0; lod <= a.cook.chain.targets.size(); ++lod) {
    names.push_back(stem + "_lod" + std::to_string(lod) + ".glb");
  }
  return names;
}

std::vector<Output> outputs(const CookArguments& a) {
  std::vector<Output> all = {{"-o", a.output}};
  if (!a.report.empty()) all.push_back({"--report", a.report});
  if (!a.depfile.empty()) all.push_back({"--depfile", a.depfile});
  if (!a.timings.empty()) all.push_back({"--timings", a.timings});
  for (const std::string& name : glb_names(a))
    all.push_back({"--gltf", (fs::path(a.gltf_folder) / name).string()});
  return all;
}

void refuse_warnings(const std::string& input, const Warnings& warnings) {
  if (warnings.empty()) return;
  std::string list;
  for (const Warning& w : warnings) list += "\n  " + text(w);
  throw Error{Fault::Input, input + ": has warnings, and --strict allows none: mend the source:" + list};
}

// Repair and weld alone, on a copy: what --strict refuses should not first be cooked for a minute.
void check_strictly(const std::string& input, const Imported& source) {
  Warnings warnings = source.warnings;
  Character character = source.character;
  for (Warning& w : repair(character)) warn(warnings, std::move(w));
  for (Warning& w : weld(character)) warn(warnings, std::move(w));
  refuse_warnings(input, warnings);
}

Imported read_character(const InputFile& input, const Console& console) {
  if (input.is_slod()) {
    throw Error{Fault::Input,
                input.name() + ": is a .slod, which is cooked already: cook the source it was made of"};
  }
  return input.character(console.readers);
}

// The source, of all its parts and with all its clips, looked at as far as the options depend on what it
// holds.
Imported read_source(const CookArguments& a, CookStory& story, const Console& console) {
  Imported source;
  for (const std::string& name : a.inputs) {
    const InputFile input(name);
    Imported part = read_character(input, console);
    if (story.input.empty()) {
      source = std::move(part);
      story.input = input.name();
    } else {
      unite(source, std::move(part), input.name());
      story.input += " + " + input.name();
    }
  }
  story.clip_files = add_clips(source, a.clips, console.readers);
  check_outputs(outputs(a), source.files_read, a.gltf_folder);
  check_pose_clips(source.character, a.cook.poses.pose_clips);
  check_kept_joints(source.character.skeleton, a.cook.chain.keep_joints);
  check_importance(source.character, a.cook.chain.importance);
  const int triangles = triangle_count(source.character.surface);
  check_order(a.cook.chain.targets, triangles);
  if (const auto remark = doubt(a.cook.chain.targets, triangles); remark && !a.quiet) {
    console.err << "skinlod: note: " << *remark << '\n';
  }
  if (a.strict) check_strictly(story.input, source);
  return source;
}

// The loader reads every file once before anybody else has to, and tells the levels' sizes.
void add_sizes(CookStory& story, std::span<const std::byte> slod) {
  const SlodFile read = read_slod(slod, story.input);
  if (read.levels.size() != story.cooked.chain.levels.size()) {
    throw Error{Fault::Ours, story.input + ": " + std::to_string(story.cooked.chain.levels.size()) +
                                 " levels were packed and " + std::to_string(read.levels.size()) +
                                 " read back"};
  }
  for (const SlodLevel& level : read.levels) story.level_bytes.push_back(level.bytes);
  story.bytes = slod.size();
}

struct File {
  std::string path;
  std::vector<std::byte> bytes;
};

File text_file(const std::string& path, const std::string& text) {
  const auto* const first = reinterpret_cast<const std::byte*>(text.data());
  return {path, {first, first + text.size()}};
}

Json timings(std::span<const StageCost> stages) {
  Json all = Json::array();
  for (const StageCost& s : stages) {
    all.push_back({{"stage", s.stage},
                   {"wall_seconds", s.wall_seconds},
                   {"cpu_seconds", s.cpu_seconds},
                   {"peak_megabytes", s.peak_megabytes}});
  }
  return {{"stages", std::move(all)}};
}

// What stands on stdout where no file does; may be nothing.
std::string result_text(const CookArguments& a, const CookStory& story) {
  if (a.json) return text(report(story));
  if (a.quiet || a.output == "-" || a.report == "-" || a.depfile == "-" || a.timings == "-") return {};
  std::ostringstream table;
  print_lod_table(table, story);
  return table.str();
}

std::vector<File> files(const CookArguments& a, const CookStory& story, const Imported& source,
                        std::vector<std::byte> slod) {
  std::vector<File> all;
  for (size_t i = 0; i < story.glb.size(); ++i) {
    all.push_back(
        {(fs::path(a.gltf_folder) / story.glb[i]).string(),
         write_glb(story.cooked.character, story.cooked.chain.levels[i].surface, source.document.get())});
  }
  if (!a.report.empty()) all.push_back(text_file(a.report, text(report(story))));
  if (!a.depfile.empty()) all.push_back(text_file(a.depfile, depfile(a.output, source.files_read)));
  all.push_back({a.output, std::move(slod)});
  if (const std::string result = result_text(a, story); !result.empty()) {
    all.push_back(text_file("-", result));
  }
  return all;
}

// All of the files appear, or none. Standard output comes first: it is the one that cannot be taken back.
void write(const std::vector<File>& files, std::ostream& out) {
  OutputSet set;
  for (const File& file : files) {
    if (file.path != "-") set.add(file.path, file.bytes);
  }
  for (const File& file : files) {
    if (file.path == "-")
      out.write(reinterpret_cast<const char*>(file.bytes.data()), std::streamsize(file.bytes.size()));
  }
  flush(out);
  set.commit();
}

void list_sources(std::ostream& err, const CookStory& story, const Imported& source) {
  for (const std::string& path : source.files_read) err << "read " << path << '\n';
  const PoseSet& poses = story.cooked.poses;
  for (const Pose& pose : poses.examples) err << "example pose: " << pose.source << '\n';
  for (const auto* unseen : {&poses.unseen_clip, &poses.unseen_motion, &poses.morphs}) {
    for (const Pose& pose : *unseen) err << "unseen pose: " << pose.source << '\n';
  }
}

// False where a level is not what was asked for, each with its reason.
bool targets_reached(const CookStory& story, std::ostream& err) {
  bool all = true;
  for (size_t i = 0; i < story.cooked.chain.levels.size(); ++i) {
    const Level& level = story.cooked.chain.levels[i];
    if (level.reached) continue;
    all = false;
    err << "skinlod: " << story.input << ": LOD" << i + (story.options.chain.source_level ? 0 : 1)
        << ": asked for " << story.target[i] << " (" << level.asked << " triangles), got "
        << triangle_count(level.surface) << ": " << level.reason << '\n';
  }
  return all;
}

}  // namespace

int cook_command(std::span<const std::string> args, const Console& console) {
  CookArguments a;
  if (!parse(a, args, console.out)) return 0;
  validate(a);
  a.cook.chain.targets = level_targets(a);
  for (const std::string& selection : a.importance)
    a.cook.chain.importance.push_back(parse_importance(selection));
  a.cook.chain.source_level = !a.no_lod0;
  a.pack.compress = !a.no_compress;
  a.cook.chain.borders = a.lock_open_borders ? Borders::Locked : Borders::Free;
  std::vector<std::string> inputs = a.clips;
  std::copy_if(a.inputs.begin(), a.inputs.end(), std::back_inserter(inputs),
               [](const std::string& input) { return input != "-"; });
  check_outputs(outputs(a), inputs, a.gltf_folder);

  const ThreadLimit threads(a.threads);
  ProgressBar bar(console.err, !a.quiet && is_terminal(console.err));
  StageClock clock;
  const bool timed = a.verbose || !a.timings.empty();
  const Progress progress = [&](std::string_view stage, double done) {
    bar(stage, done);
    if (timed) clock(stage);
  };

  CookStory story{.options = a.cook, .pack = a.pack, .glb = glb_names(a)};
  progress("reading", 0);
  Imported source = read_source(a, story, console);
  story.cooked = cook(std::move(source.character), a.cook, progress);
  story.warnings = std::move(source.warnings);
  for (const Warning& warning : story.cooked.warnings) warn(story.warnings, warning);
  if (a.strict) refuse_warnings(story.input, story.warnings);
  if (a.cook.chain.source_level) story.target.push_back("source");
  for (const LevelTarget& target : a.cook.chain.targets) story.target.push_back(text(target));

  progress("packing", 0);
  std::vector<std::byte> slod = pack(story.cooked.character, story.cooked.chain.levels, a.pack);
  add_sizes(story, slod);
  progress("writing", 0);
  std::vector<File> all = files(a, story, source, std::move(slod));
  const std::vector<StageCost> stages = clock.stop();
  if (!a.timings.empty()) all.push_back(text_file(a.timings, text(timings(stages))));
  bar.clear();
  if (!a.quiet) {
    for (const Warning& warning : story.warnings)
      console.err << "skinlod: warning: " << text(warning) << '\n';
  }
  if (a.verbose) {
    list_sources(console.err, story, source);
    print_stages(console.err, stages);
  }
  MadeFolder folder(a.gltf_folder);
  write(all, console.out);
  folder.keep();
  return targets_reached(story, console.err) ? 0 : 1;
}

}  // namespace skinlod
