// SPDX-License-Identifier: MIT
#include "pipeline/evaluate.h"

#include <chrono>

#include "pipeline/parallel.h"
#include "tests/bench/bench.h"
#include "tests/bench/clock.h"
#include "tests/bench/method.h"
#include "tests/bench/subject.h"
#include "tools/command_line.h"
#include "tools/table.h"

// What `skinlod evaluate` costs: a character of 50,000 triangles and its quarter level, in ever more poses
// and from ever more samples.
namespace skinlod {
namespace {

constexpr int kPoseCounts[] = {10, 20, 40};
constexpr int kCounts[] = {5000, 10000, 20000};  // samples

struct Pair {
  Character character;
  Surface level;
  std::vector<Pose> poses;
};

// content/humanoid.glb has half as many triangles; cut in four each, and simplified to half of those.
Pair make_pair() {
  constexpr int kTriangles = 50000;
  Character character = with_seams_free(load_character(SKINLOD_ROOT "/content/humanoid.glb"));
  character.surface = subdivided(character.surface, 2);
  PoseSet set = choose_poses(character, {.unseen_clip_frames = 32});
  const int targets[] = {kTriangles, kTriangles / 4};
  std::vector<Surface> levels = make_levels(methods().front(), character, set.examples, targets);
  character.surface = std::move(levels[0]);
  Pair pair{std::move(character), std::move(levels[1]), std::move(set.unseen_clip)};
  pair.poses.insert(pair.poses.end(), set.unseen_motion.begin(), set.unseen_motion.end());
  return pair;
}

double wall_seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void print_costs(std::ostream& out, const std::vector<Json>& lines) {
  std::vector<std::vector<std::string>> rows = {
      {"bound", "poses", "samples", "seconds", "us per pose and sample", "ms per pose"}};
  for (const Json& line : lines) {
    rows.push_back({line["bound"].get<bool>() ? "near" : "none", line["poses"].dump(),
                    grouped(line["samples"].get<int>()), rounded(line["cpu_seconds"].get<double>()),
                    rounded(line["us_per_pose_and_sample"].get<double>()),
                    rounded(line["ms_per_pose"].get<double>())});
  }
  print_table(out, rows);
}

}  // namespace

int evaluate_command(Args args, const Streams& streams) {
  int runs = 1;
  CommandLine line("evaluate", "[options]",
                   "Times the evaluation of a character of 50,000 triangles against its quarter level.",
                   "skinlod_bench");
  line.number("--runs", "COUNT", runs, 1, 99, "of which the median counts");
  if (!line.parse(args, streams.out)) return 0;

  const Pair pair = make_pair();
  const Surface* levels[] = {&pair.level};
  // Fewer poses are every second or fourth of all, so that they are alike.
  const auto evaluate = [&](int count, int samples, bool bound) {
    std::vector<Pose> poses;
    for (int i = 0; i < count; ++i)
      poses.push_back(pair.poses[size_t(i) * pair.poses.size() / size_t(count)]);
    (void)deviations(pair.character.surface, levels, poses,
                     {.samples = samples, .attributes = true, .bound = bound});
  };
  std::vector<Json> lines;
  for (const bool bound : {false, true}) {
    for (const int poses : kPoseCounts) {
      for (const int samples : kCounts) {
        const double seconds = cost_of(runs, [&] { evaluate(poses, samples, bound); }).cpu_seconds;
        lines.push_back({{"bench", "evaluate"},
                         {"source_triangles", triangle_count(pair.character.surface)},
                         {"triangles", triangle_count(pair.level)},
                         {"bound", bound},
                         {"poses", poses},
                         {"samples", samples},
                         {"cpu_seconds", seconds},
                         {"us_per_pose_and_sample", 1e6 * seconds / poses / samples},
                         {"ms_per_pose", 1e3 * seconds / poses}});
        print_line(streams.out, lines.back());
      }
    }
  }
  streams.err << "CPU time, one thread: " << grouped(triangle_count(pair.character.surface))
              << " triangles and " << grouped(triangle_count(pair.level)) << ", attributes compared\n\n";
  print_costs(streams.err, lines);
  const double wall = wall_seconds([&] { evaluate(std::end(kPoseCounts)[-1], std::end(kCounts)[-1], true); });
  streams.err << "\nThe last on all threads: " << rounded(wall) << " s of wall time\n";
  return 0;
}

}  // namespace skinlod
