// SPDX-License-Identifier: MIT
#include <map>

#include "pipeline/error.h"
#include "pipeline/evaluate.h"
#include "tests/bench/bench.h"
#include "tests/bench/clock.h"
#include "tests/bench/method.h"
#include "tests/bench/subject.h"
#include "tools/command_line.h"
#include "tools/table.h"

namespace skinlod {
namespace {

// As far as the paper's Table 1 goes: the whole hierarchy.
constexpr int kTriangles = 70;
const char* const kUnit = "meshopt_simplify";

struct SpeedArguments {
  SubjectOptions subjects{.only = {}, .folder = shared_characters()};
  int runs = 3;
};

struct Timed {
  double seconds;
  Surface level;
};

Timed time_collapse(const Method& method, const Character& character, const PoseSet& poses, int runs) {
  const int target[] = {kTriangles};
  Timed timed{};
  timed.seconds = user_seconds(
      runs, [&] { timed.level = make_levels(method, character, poses.examples, target).front(); });
  return timed;
}

std::vector<Json> measure(const Subject& subject, int runs) {
  Character character = subject.make();
  const PoseSet poses = choose_poses(character, {});
  // As in the papers: with seams held most characters stop long before.
  character = with_seams_free(character);
  const Surface& source = character.surface;
  const Json head = {{"bench", "speed"}, {"character", subject.name}, {"class", subject.kind}};
  const double unit = time_collapse(method(kUnit), character, poses, runs).seconds;
  std::vector<Json> lines;
  const auto add = [&](const std::string& name, double seconds, int triangles) {
    Json& line = lines.emplace_back(head);
    line["method"] = name;
    line["source_triangles"] = triangle_count(source);
    line["triangles"] = triangles;
    line["poses"] = poses.examples.size();
    line["user_seconds"] = seconds;
    line["ratio"] = seconds / unit;
  };
  for (const Method& m : methods()) {
    const Timed timed = time_collapse(m, character, poses, runs);
    add(m.name, timed.seconds, triangle_count(timed.level));
  }
  const int quarter[] = {std::max(1, triangle_count(source) / 4)};
  const Surface level = make_levels(methods().front(), character, poses.examples, quarter).front();
  const Surface* levels[] = {&level};
  for (const bool bound : {false, true}) {
    DeviationOptions options{.bound = bound};
    options.groups.assign(poses.examples.size(), 0);
    const double seconds =
        user_seconds(runs, [&] { (void)deviations(source, levels, poses.examples, options); });
    add(bound ? "evaluate with bound" : "evaluate", seconds, triangle_count(level));
  }
  return lines;
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
  out << "User CPU time, one thread, as multiples of " << kUnit << "'s on the same mesh: collapse to "
      << kTriangles << " triangles;\nevaluation of the quarter level in all example poses\n\n";
  print_table(out, rows);
}

}  // namespace

int speed_command(Args args, const Streams& streams) {
  SpeedArguments a;
  CommandLine line("speed", "[options]",
                   "Times every method on every character, on one thread, as multiples of meshopt_simplify.",
                   "skinlod_bench");
  line.words("--only", "WORD", a.subjects.only, "characters with this in their name; may be repeated");
  line.word("--characters", "DIR", a.subjects.folder, "other people's characters, where they are there");
  line.number("--runs", "COUNT", a.runs, 1, 99, "of which the median counts");
  if (!line.parse(args, streams.out)) return 0;
  std::vector<Json> lines;
  int failed = 0;
  for (const Subject& subject : subjects(a.subjects)) {
    try {
      for (Json& found : measure(subject, a.runs)) {
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
