// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "pipeline/error.h"
#include "pipeline/evaluate.h"
#include "pipeline/metrics/per_frame.h"
#include "pipeline/parallel.h"
#include "tests/bench/bench.h"
#include "tests/bench/method.h"
#include "tests/bench/subject.h"
#include "tools/command_line.h"
#include "tools/levels.h"
#include "tools/table.h"

namespace skinlod {
namespace {

constexpr double kDegrees = 57.29577951308232;  // in a radian

struct QualityArguments {
  SubjectOptions subjects{.only = {}, .folder = shared_characters()};
  std::vector<std::string> methods = method_names();
  std::string levels = "50%,25%,10%,5%";
  PoseOptions poses{};
  int unseen = 8;  // poses of each kind to measure in
  int cap = LevelTarget{}.max_influences;
  int jobs = 0;  // 0: all there are
  bool table = false, held_alone = false, free_alone = false;
};

// The errors over both kinds of poses that no method has seen.
struct Unseen {
  PosedError clip{}, motion{};
  Spread normal{}, uv{};  // radians, and in the texture's own unit: over the clips
};

// One method at one level. Seams are held where texture charts keep their outline, and free where positions
// alone count.
struct Case {
  std::string method;
  bool seams_held;
  size_t level;
  Surface surface;
  Unseen error{};
};

class Quality {
 public:
  Quality(const QualityArguments& a, const Subject& subject)
      : a_(a), subject_(subject), character_(subject.make()), poses_(choose_poses(character_, a.poses)) {
    source_ = triangulated(character_.surface);
    size_ = diagonal(source_.position);
    thin(poses_.unseen_clip), thin(poses_.unseen_motion);
    for (const auto* set : {&poses_.unseen_clip, &poses_.unseen_motion})
      unseen_.insert(unseen_.end(), set->begin(), set->end());
    for (const LevelTarget& target : parse_lods(a.levels)) {
      names_.push_back(text(target));
      const int count = target.triangles ? *target.triangles : int(*target.ratio * triangle_count(source_));
      counts_.push_back(std::max(1, count));
    }
  }

  std::vector<Json> measure() {
    make_cases();
    measure_cases();
    measure_frames();
    std::vector<Json> lines;
    for (const int count : frame_counts()) {
      const auto at = std::find(counts_.begin(), counts_.end(), count);
      if (at == counts_.end()) continue;
      const size_t level = size_t(at - counts_.begin());
      lines.push_back(
          line("per_frame", "free", level, frame_triangles_.at(count), frames_.at(count), frames_.at(count)));
    }
    for (const Case& c : cases_) {
      const int triangles = triangle_count(c.surface);
      lines.push_back(line(c.method, c.seams_held ? "held" : "free", c.level, triangles, c.error,
                           frames_.at(frame_count(c))));
    }
    return lines;
  }

 private:
  void thin(std::vector<Pose>& poses) const {
    std::vector<Pose> some;
    const size_t n = std::min(poses.size(), size_t(a_.unseen));
    for (size_t i = 0; i < n; ++i) some.push_back(poses[(2 * i + 1) * poses.size() / (2 * n)]);
    poses = std::move(some);
  }

  void make_cases() {
    struct Job {
      const Method* method;
      bool seams_held;
    };
    std::vector<Job> jobs;
    for (const bool held : {true, false}) {
      if (held ? a_.free_alone : a_.held_alone) continue;
      for (const std::string& name : a_.methods) jobs.push_back({&method(name), held});
    }
    const Character free = with_seams_free(character_);
    std::vector<std::vector<Surface>> made(jobs.size());
    parallel_for(int(jobs.size()), [&](int i) {
      Method m = *jobs[i].method;
      if (m.cap > 0) m.cap = a_.cap;
      made[i] = make_levels(m, jobs[i].seams_held ? character_ : free, poses_.examples, counts_);
    });
    for (size_t i = 0; i < jobs.size(); ++i) {
      for (size_t l = 0; l < counts_.size(); ++l)
        cases_.push_back({jobs[i].method->name, jobs[i].seams_held, l, std::move(made[i][l])});
    }
  }

  void measure_cases() {
    std::vector<const Surface*> surfaces;
    for (const Case& c : cases_) surfaces.push_back(&c.surface);
    const std::array<std::span<const Pose>, 2> sets = {poses_.unseen_clip, poses_.unseen_motion};
    const auto errors = posed_errors(source_, surfaces, sets);
    const auto dressed =
        deviations(source_, surfaces, poses_.unseen_clip, {.attributes = true, .bound = false});
    for (size_t i = 0; i < cases_.size(); ++i) {
      std::vector<double> normal, uv;
      for (const Deviation& d : dressed[i]) {
        normal.insert(normal.end(), d.normal.begin(), d.normal.end());
        uv.insert(uv.end(), d.uv.begin(), d.uv.end());
      }
      cases_[i].error = {errors[i][0], errors[i][1], spread(std::move(normal)), spread(std::move(uv))};
    }
  }

  Unseen unseen(std::span<const Deviation> found) const {
    const size_t clips = poses_.unseen_clip.size();
    return {posed_error(found.first(clips)), posed_error(found.subspan(clips))};
  }

  // What a case is held against: per_frame at the level's number, or at the case's own where it stopped
  // short.
  int frame_count(const Case& c) const { return std::max(counts_[c.level], triangle_count(c.surface)); }

  std::set<int, std::greater<>> frame_counts() const {
    std::set<int, std::greater<>> counts(counts_.begin(), counts_.end());
    for (const Case& c : cases_) counts.insert(frame_count(c));
    return counts;
  }

  void measure_frames() {
    const auto set = frame_counts();
    const std::vector<int> counts(set.begin(), set.end());
    const Pose still{"bind", {identity()}};
    std::vector<std::vector<Deviation>> found(counts.size(), std::vector<Deviation>(unseen_.size()));
    std::vector<std::vector<int>> triangles(counts.size(), std::vector<int>(unseen_.size()));
    parallel_for(int(unseen_.size()), [&](int p) {
      const Pose& pose = unseen_[p];
      const auto posed = pose_vertices(source_, pose.palette, pose.morph_weights);
      const auto frames = simplify_frame(source_, posed, counts);
      std::vector<Animated> animated;
      for (const Surface& frame : frames) animated.push_back({&frame, {&still, 1}});
      auto in_pose = deviations(Animated{&source_, {&pose, 1}}, animated);
      for (size_t n = 0; n < counts.size(); ++n) {
        found[n][p] = std::move(in_pose[n].front());
        triangles[n][p] = triangle_count(frames[n]);
      }
    });
    for (size_t n = 0; n < counts.size(); ++n) {
      frames_[counts[n]] = unseen(found[n]);
      frame_triangles_[counts[n]] =
          triangles[n].empty() ? 0 : *std::max_element(triangles[n].begin(), triangles[n].end());
    }
  }

  Json line(const std::string& name, const char* seams, size_t level, int triangles, const Unseen& error,
            const Unseen& frame) const {
    Json json = {{"bench", "quality"},      {"character", subject_.name},
                 {"class", subject_.kind},  {"seams", seams},
                 {"method", name},          {"level", names_[level]},
                 {"asked", counts_[level]}, {"triangles", triangles}};
    const auto add = [&](const char* poses, const PosedError& its, const PosedError& best, bool measured) {
      json[poses] = nullptr;
      // Below this share of the diagonal per_frame's error is rounding, and no measure for another's.
      constexpr double kNothing = 1e-9;
      if (!measured) return;
      json[poses] = {{"rms_percent", 100 * its.rms / size_}, {"max_percent", 100 * its.max / size_}};
      if (best.rms > kNothing * size_) {
        json[poses]["rms_ratio"] = its.rms / best.rms;
        json[poses]["max_ratio"] = its.max / best.max;
      }
    };
    add("clip", error.clip, frame.clip, !poses_.unseen_clip.empty());
    add("motion", error.motion, frame.motion, !poses_.unseen_motion.empty());
    if (json["seams"] == "held") {
      json["normal_degrees"] = error.normal.rms * kDegrees;
      json["uv"] = error.uv.rms;
    }
    return json;
  }

  const QualityArguments& a_;
  const Subject& subject_;
  Character character_;
  PoseSet poses_;
  std::vector<Pose> unseen_;
  Surface source_;
  double size_ = 0;
  std::vector<std::string> names_;  // per level
  std::vector<int> counts_;         // per level
  std::vector<Case> cases_;
  std::map<int, Unseen> frames_;        // per_frame by triangles
  std::map<int, int> frame_triangles_;  // the most of any frame
};

// Geometric means over the levels of the characters for which `wanted` holds.
class Means {
 public:
  explicit Means(const std::vector<Json>& lines) : lines_(lines) {}

  std::optional<double> of(const char* poses, const char* what, const auto& wanted) const {
    std::vector<double> ratios;
    for (const Json& line : lines_) {
      if (!wanted(line) || line[poses].is_null() || !line[poses].contains(what)) continue;
      if (const double ratio = line[poses][what]; ratio > 0) ratios.push_back(ratio);
    }
    return mean(ratios);
  }

  std::optional<double> of(const char* what, const auto& wanted) const {
    std::vector<double> values;
    for (const Json& line : lines_) {
      if (wanted(line) && line.value(what, 0.0) > 0) values.push_back(line[what]);
    }
    return mean(values);
  }

 private:
  static std::optional<double> mean(const std::vector<double>& values) {
    if (values.empty()) return std::nullopt;
    return geometric_mean(values);
  }

  const std::vector<Json>& lines_;
};

constexpr std::array<const char*, 2> kPoses = {"clip", "motion"};
constexpr std::array<const char*, 2> kErrors = {"rms_ratio", "max_ratio"};

std::vector<Json> mean_lines(const std::vector<Json>& lines, const std::vector<std::string>& methods) {
  const Means means(lines);
  std::vector<Json> found;
  for (const char* kind : kKinds) {
    for (const char* seams : {"held", "free"}) {
      for (const std::string& name : methods) {
        const auto wanted = [&](const Json& line) {
          return line["class"] == kind && line["seams"] == seams && line["method"] == name;
        };
        Json json = {{"bench", "quality_mean"}, {"class", kind}, {"seams", seams}, {"method", name}};
        json["cases"] = std::count_if(lines.begin(), lines.end(), wanted);
        json["unreached"] = std::count_if(lines.begin(), lines.end(), [&](const Json& line) {
          return wanted(line) && line["triangles"] > line["asked"];
        });
        if (json["cases"] == 0) continue;
        for (const char* poses : kPoses) {
          json[poses] = nullptr;
          for (const char* what : kErrors) {
            if (const auto mean = means.of(poses, what, wanted)) json[poses][what] = *mean;
          }
        }
        for (const char* what : {"normal_degrees", "uv"}) {
          if (const auto mean = means.of(what, wanted)) json[what] = *mean;
        }
        found.push_back(json);
      }
    }
  }
  return found;
}

std::string cell(const Json& json, const char* poses, const char* what) {
  return json[poses].is_null() || !json[poses].contains(what) ? "-"
                                                              : rounded(json[poses][what].get<double>());
}

std::string cell(const Json& json, const char* what) {
  return json.contains(what) ? rounded(json[what].get<double>()) : "-";
}

void print_tables(std::ostream& out, const std::vector<Json>& lines, const std::vector<Json>& means,
                  const std::vector<std::string>& methods) {
  out << "Posed error as a multiple of per_frame's, and how far normals and uvs are off: geometric means "
         "over\n"
         "characters and levels\n\n";
  std::vector<std::vector<std::string>> rows = {
      {"", "", "", "unseen", "clips", "range of", "motion", "normals", "uvs", "", ""},
      {"class", "seams", "method", "RMS", "max", "RMS", "max", "degrees", "RMS", "levels", "stopped short"}};
  for (const Json& m : means) {
    rows.push_back({m["class"], m["seams"], m["method"], cell(m, "clip", "rms_ratio"),
                    cell(m, "clip", "max_ratio"), cell(m, "motion", "rms_ratio"),
                    cell(m, "motion", "max_ratio"), cell(m, "normal_degrees"), cell(m, "uv"),
                    m["cases"].dump(), m["unreached"].dump()});
  }
  print_table(out, rows);

  out << "\nRMS on unseen clips by level, as multiples of per_frame's: geometric means over characters\n\n";
  std::vector<std::string> levels;
  for (const Json& line : lines) {
    if (std::find(levels.begin(), levels.end(), line["level"]) == levels.end())
      levels.push_back(line["level"]);
  }
  rows = {{"class", "seams", "method"}};
  rows.front().insert(rows.front().end(), levels.begin(), levels.end());
  for (const Json& m : means) {
    auto& row = rows.emplace_back(std::vector<std::string>{m["class"], m["seams"], m["method"]});
    for (const std::string& level : levels) {
      const auto mean = Means(lines).of("clip", "rms_ratio", [&](const Json& line) {
        return line["class"] == m["class"] && line["seams"] == m["seams"] && line["method"] == m["method"] &&
               line["level"] == level;
      });
      row.push_back(mean ? rounded(*mean) : "-");
    }
  }
  print_table(out, rows);

  out << "\nRMS on unseen clips by character, as multiples of per_frame's: geometric means over levels\n\n";
  std::set<std::pair<std::string, std::string>> characters;  // with their class
  for (const Json& line : lines) characters.emplace(line["class"], line["character"]);
  rows = {{"character", "class", "seams"}};
  rows.front().insert(rows.front().end(), methods.begin(), methods.end());
  for (const auto& entry : characters) {
    const auto& kind = entry.first;
    const auto& character = entry.second;
    for (const char* seams : {"held", "free"}) {
      auto& row = rows.emplace_back(std::vector<std::string>{character, kind, seams});
      for (const std::string& name : methods) {
        const auto mean = Means(lines).of("clip", "rms_ratio", [&](const Json& line) {
          return line["character"] == character && line["seams"] == seams && line["method"] == name;
        });
        row.push_back(mean ? rounded(*mean) : "-");
      }
    }
  }
  print_table(out, rows);
}

bool parse(QualityArguments& a, Args args, std::ostream& out) {
  CommandLine line("quality", "[options]",
                   "Measures every method on every character: RMS and largest posed error, as multiples of "
                   "what static\nsimplification of each posed frame comes to (per_frame).",
                   "skinlod_bench");
  line.words("--only", "WORD", a.subjects.only, "characters with this in their name; may be repeated");
  line.word("--characters", "DIR", a.subjects.folder, "other people's characters, where they are there");
  std::vector<size_t> chosen(methods().size());
  for (size_t i = 0; i < chosen.size(); ++i) chosen[i] = i;
  line.choices("--metrics", chosen, method_names(), "what to compare");
  line.word("--levels", "LIST", a.levels, "shares of the triangles (50%) or numbers of them (5000)");
  line.flag("--held", a.held_alone, "with seams held alone; else both");
  line.flag("--free", a.free_alone, "with seams free alone; else both");
  line.number("--cap", "COUNT", a.cap, 1, 8, "influences per vertex, where a method has a cap");
  line.number("--poses", "COUNT", a.poses.from_clips, 0, 1000, "example poses chosen from the clips");
  line.number("--rom", "COUNT", a.poses.range_of_motion, 0, 1000, "example poses from ranges of motion");
  line.number("--unseen", "COUNT", a.unseen, 1, 1000, "poses of each kind to measure in");
  line.number("--jobs", "COUNT", a.jobs, 0, 1024, "threads, 0 for all; no result depends on it");
  line.flag("--table", a.table, "the tables on standard output, and no lines");
  if (!line.parse(args, out)) return false;
  a.methods.clear();
  for (const size_t i : chosen) a.methods.push_back(methods()[i].name);
  if (a.held_alone && a.free_alone) throw Error{Fault::Usage, "--held: contradicts --free: give one"};
  return true;
}

}  // namespace

int quality_command(Args args, const Streams& streams) {
  QualityArguments a;
  if (!parse(a, args, streams.out)) return 0;
  const ThreadLimit threads(a.jobs);

  std::vector<Json> lines;
  int failed = 0;
  for (const Subject& subject : subjects(a.subjects)) {
    streams.err << subject.name << '\n';
    try {
      for (Json& line : Quality(a, subject).measure()) lines.push_back(std::move(line));
    } catch (const Error& e) {
      streams.err << "skinlod_bench: " << subject.name << ": " << e.what() << '\n';
      ++failed;
      continue;
    }
    for (const Json& line : lines) {
      if (!a.table && line["character"] == subject.name) print_line(streams.out, line);
    }
  }
  const std::vector<Json> means = mean_lines(lines, a.methods);
  for (const Json& mean : means) {
    if (!a.table) print_line(streams.out, mean);
  }
  print_tables(a.table ? streams.out : streams.err, lines, means, a.methods);
  return failed > 0 ? 1 : 0;
}

}  // namespace skinlod
