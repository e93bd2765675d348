// SPDX-License-Identifier: MIT
#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "pipeline/baseline.h"
#include "pipeline/cook.h"
#include "pipeline/error.h"
#include "pipeline/evaluate.h"
#include "pipeline/influences.h"
#include "pipeline/pack.h"
#include "tests/bench/bench.h"
#include "tests/bench/clock.h"
#include "tests/bench/method.h"
#include "tests/bench/subject.h"
#include "tools/command_line.h"
#include "tools/levels.h"
#include "tools/stage_clock.h"
#include "tools/table.h"

namespace skinlod {
namespace {

// As far as the paper's Table 1 goes: the whole hierarchy.
constexpr int kTriangles = 70;
const std::string kUnit = "meshopt_simplify";

struct SpeedArguments {
  SubjectOptions subjects{.only = {}, .folder = shared_characters()};
  std::vector<size_t> methods{};
  PoseOptions poses{};
  int runs = 3;
  int cut = 1;
};

// Of a cut face's vertices some follow the joints of all three corners: more than artists' vertices do.
Character made(const Subject& subject, int cut) {
  Character character = subject.make();
  if (cut == 1) return character;
  character.surface = subdivided(character.surface, cut);
  character.morphs.clear();
  for (Influences& influences : character.surface.influences)
    influences = largest(std::move(influences), LevelTarget{}.max_influences);
  return character;
}

// As `skinlod cook` does it: levels of a half to a twentieth, fitted and measured, and the bytes of a .slod.
std::vector<StageCost> cook_and_pack(const Character& character, const PoseOptions& poses) {
  StageClock clock;
  const Cooked cooked = cook(character, {.poses = poses, .chain = {.targets = parse_lods("50%,25%,10%,5%")}},
                             [&](std::string_view stage, double) { clock(stage); });
  clock("packing");
  (void)pack(cooked.character, cooked.chain.levels);
  return clock.stop();
}

// The unit is timed again after each: a machine that others use too is not as fast all the time.
class Timings {
 public:
  Timings(const Subject& subject, const Character& character, size_t poses, std::function<Cost()> unit)
      : head_({{"bench", "speed"},
               {"character", subject.name},
               {"class", subject.kind},
               {"source_triangles", triangle_count(character.surface)},
               {"poses", poses}}),
        unit_(std::move(unit)),
        before_(unit_()) {}

  // On one thread CPU time is compared; on more, wall time: what a thread waits for counts there.
  Json& add(const std::string& name, const Cost& cost, int threads = 1) {
    Json& line = lines_.emplace_back(head_);
    line["method"] = name;
    line["threads"] = threads;
    line["cpu_seconds"] = cost.cpu_seconds;
    line["wall_seconds"] = cost.wall_seconds;
    line["peak_megabytes"] = cost.peak_megabytes;
    const Cost after = unit_();
    const auto ratio = [&](double Cost::*seconds) {
      return cost.*seconds / ((before_.*seconds + after.*seconds) / 2);
    };
    line["ratio"] = threads == 1 ? ratio(&Cost::cpu_seconds) : ratio(&Cost::wall_seconds);
    before_ = after;
    return line;
  }

  // A peak is that of the costliest stage: each begins with the peaks before it forgotten.
  void add_cook(Cost cost, const std::vector<StageCost>& stages) {
    Json of_stages;
    for (const StageCost& s : stages) {
      cost.peak_megabytes = std::max(cost.peak_megabytes, s.peak_megabytes);
      of_stages[s.stage] = {{"cpu_seconds", s.cpu_seconds},
                            {"wall_seconds", s.wall_seconds},
                            {"peak_megabytes", s.peak_megabytes}};
    }
    add("cook, 2 threads", cost, 2)["stages"] = std::move(of_stages);
  }

  std::vector<Json> take() { return std::move(lines_); }

 private:
  Json head_;
  std::function<Cost()> unit_;
  Cost before_;
  std::vector<Json> lines_;
};

std::vector<Json> measure(const Subject& subject, const SpeedArguments& a, std::ostream& err) {
  const Character character = made(subject, a.cut);
  const std::vector<Pose> examples = choose_poses(character, a.poses).examples;
  // As in the papers: with seams held most characters stop long before.
  const Character free = with_seams_free(character);
  const MeshoptInput input(triangulated(free.surface));
  const auto unit = [&] { return cost_of(a.runs, [&] { (void)input.simplified(kTriangles); }); };
  const auto collapsed = [&](const Method& m, int threads = 1) {
    const int target[] = {kTriangles};
    return cost_of(
        a.runs, [&] { (void)make_levels(m, free, examples, target); }, threads);
  };
  Timings timings(subject, character, examples.size(), unit);
  for (const size_t m : a.methods)
    timings.add(methods()[m].name, methods()[m].name == kUnit ? unit() : collapsed(methods()[m]));
  timings.add("articulated, 2 threads", collapsed(method("articulated"), 2), 2);
  std::vector<StageCost> stages;
  const Cost cooking = cost_of(
      a.runs, [&] { stages = cook_and_pack(character, a.poses); }, 2);
  timings.add_cook(cooking, stages);
  err << subject.name << ", the cook on 2 threads:\n";
  print_stages(err, stages);
  err << '\n';

  const int quarter[] = {std::max(1, triangle_count(free.surface) / 4)};
  const Surface level = make_levels(method("articulated"), free, examples, quarter).front();
  const Surface* levels[] = {&level};
  for (const bool bound : {false, true}) {
    DeviationOptions options{.bound = bound};
    options.groups.assign(examples.size(), 0);
    timings.add(bound ? "evaluate with bound" : "evaluate",
                cost_of(a.runs, [&] { (void)deviations(free.surface, levels, examples, options); }));
  }
  return timings.take();
}

void print_table_of(std::ostream& out, const std::vector<Json>& lines) {
  std::vector<std::vector<std::string>> rows = {{"character", "triangles", "poses"}};
  std::map<std::string, std::vector<double>> ratios;
  std::vector<std::string> names;
  for (const Json& line : lines) {
    if (rows.back().front() != line["character"]) {
      rows.push_back({line["character"], grouped(line["source_triangles"].get<int>()), line["poses"].dump()});
    }
    rows.back().push_back(rounded(line["ratio"].get<double>()));
    const std::string name = line["method"];
    if (!ratios.contains(name)) names.push_back(name);
    ratios[name].push_back(line["ratio"]);
  }
  rows.front().insert(rows.front().end(), names.begin(), names.end());
  auto& means = rows.emplace_back(std::vector<std::string>{"geometric mean", "", ""});
  for (const std::string& name : names) means.push_back(rounded(geometric_mean(ratios[name])));
  out << "Time as multiples of one call of " << kUnit << " on the same mesh: collapse to " << kTriangles
      << " triangles with seams free;\nthe whole cook of four levels; evaluation of a quarter level in all "
         "example poses. CPU time, wall time for 2 threads\n\n";
  print_table(out, rows);
}

}  // namespace

int speed_command(Args args, const Streams& streams) {
  SpeedArguments a;
  for (size_t m = 0; m < methods().size(); ++m) a.methods.push_back(m);
  CommandLine line(
      "speed", "[options]",
      "Times every method, and the whole cook, on every character, as multiples of meshopt_simplify.",
      "skinlod_bench");
  line.words("--only", "WORD", a.subjects.only, "characters with this in their name; may be repeated");
  line.word("--characters", "DIR", a.subjects.folder, "other people's characters, where they are there");
  line.choices("--metrics", a.methods, method_names(), "what to time");
  line.number("--cut", "N", a.cut, 1, 99, "every triangle into N x N first");
  line.number("--poses", "COUNT", a.poses.from_clips, 0, 1000, "example poses chosen from the clips");
  line.number("--rom", "COUNT", a.poses.range_of_motion, 0, 1000, "example poses from ranges of motion");
  line.number("--runs", "COUNT", a.runs, 1, 99, "of which the median counts");
  if (!line.parse(args, streams.out)) return 0;
  std::vector<Json> lines;
  int failed = 0;
  for (const Subject& subject : subjects(a.subjects)) {
    try {
      for (Json& found : measure(subject, a, streams.err)) {
        print_line(streams.out, found);
        lines.push_back(std::move(found));
      }
    } catch (const Error& e) {
      streams.err << "skinlod_bench: " << subject.name << ": " << e.what() << '\n';
      ++failed;
    }
  }
  print_table_of(streams.err, lines);
  return failed > 0 ? 1 : 0;
}

}  // namespace skinlod
