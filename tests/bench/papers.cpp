// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "pipeline/error.h"
#include "pipeline/evaluate.h"
#include "pipeline/metrics/per_frame.h"
#include "pipeline/parallel.h"
#include "pipeline/repair.h"
#include "tests/bench/bench.h"
#include "tests/bench/clock.h"
#include "tests/bench/method.h"
#include "tests/bench/subject.h"
#include "tests/shapes.h"
#include "tools/command_line.h"

// What Landreneau & Schaefer 2009 print, measured again: tools/paper_tables.py makes pages of it. Seams are
// free, as in the paper's models.
namespace skinlod {
namespace {

enum class Chapter { All, Table1, Figure2, Figure4, Figure5 };

struct PapersArguments {
  std::string folder = shared_characters();
  Chapter chapter = Chapter::All;
  int runs = 1;
};

// Nine triangles for each: as near to the paper's 206,672 and 240,448 as whole cuts come.
constexpr int kCuts = 3;

const std::vector<std::string> kCompared = {"endpoint", "pose_independent", "articulated_uncapped",
                                            "articulated"};

// One of the paper's models, or what stands in for it.
struct Model {
  std::string name;   // ours
  std::string paper;  // the paper's
  int poses;          // examples, the bind pose among them
  Character character;
};

Character finer(Character character, int n) {
  character.surface = subdivided(character.surface, n);
  return character;
}

Character content(const std::string& name) {
  return with_seams_free(load_character(SKINLOD_ROOT "/content/" + name));
}

// A character of the folder, if it is there.
void add_other(std::vector<Model>& models, const PapersArguments& a, const std::string& file,
               const std::string& paper, int poses) {
  const auto path = std::filesystem::path(a.folder) / file;
  if (!std::filesystem::exists(path)) return;
  models.push_back({file.substr(0, file.find('/')), paper, poses, with_seams_free(load_character(path))});
}

PoseSet example_poses(const Model& model, int unseen) {
  return choose_poses(model.character, {.from_clips = model.poses - 1,
                                        .range_of_motion = 0,
                                        .unseen_clip_frames = unseen,
                                        .unseen_range_of_motion = 0});
}

double percent(const Model& model, double metres) {
  return 100 * metres / diagonal(model.character.surface.position);
}

Json head(const char* part, const Model& model) {
  return {{"bench", "papers"},
          {"part", part},
          {"model", model.name},
          {"paper_model", model.paper},
          {"source_triangles", triangle_count(model.character.surface)},
          {"poses", model.poses}};
}

int most_influences(const Surface& surface) {
  size_t most = 0;
  for (const Influences& i : surface.influences) most = std::max(most, i.size());
  return int(most);
}

double mean_influences(const Surface& surface) {
  double sum = 0;
  for (const Influences& i : surface.influences) sum += double(i.size());
  return sum / double(surface.influences.size());
}

// Time to the hierarchy of 70 polygons, with what it takes to begin.
void table1(const PapersArguments& a, const Streams& streams) {
  std::vector<Model> models;
  models.push_back({"centipede", "Centipede", 5, finer(content("centipede.glb"), kCuts)});
  add_other(models, a, "mannequiny/mannequiny.glb", "Cheb", 27);
  add_other(models, a, "makehuman_female/mh_female.glb", "Lion", 33);
  models.push_back({"square column", "Square Column", 4, square_column()});
  models.push_back({"humanoid", "Human", 9, finer(content("humanoid.glb"), kCuts)});
  for (const Model& model : models) {
    streams.err << "table 1: " << model.name << '\n';
    const PoseSet poses = example_poses(model, 0);
    const int target[] = {70};
    for (const std::string& name : kCompared) {
      Surface level;
      const double seconds = user_seconds(a.runs, [&] {
        level = make_levels(method(name), model.character, poses.examples, target).front();
      });
      Json line = head("table1", model);
      line["method"] = name;
      line["examples"] = poses.examples.size();
      line["triangles"] = triangle_count(level);
      line["user_seconds"] = seconds;
      print_line(streams.out, line);
    }
  }
}

// The same share of the triangles as the paper's 3,000 of 13,334, with and without a cap.
void figure2(const PapersArguments& a, const Streams& streams) {
  std::vector<Model> models;
  models.push_back({"humanoid", "Lion", 9, content("humanoid.glb")});
  models.push_back({"centipede", "Lion", 9, content("centipede.glb")});
  add_other(models, a, "mannequiny/mannequiny.glb", "Lion", 9);
  add_other(models, a, "makehuman_female/mh_female.glb", "Lion", 9);
  for (const Model& model : models) {
    streams.err << "figure 2: " << model.name << '\n';
    const PoseSet poses = example_poses(model, 12);
    const int target[] = {triangle_count(model.character.surface) * 3000 / 13334};
    for (const int cap : {0, 5, 4}) {
      Method m = method("articulated");
      m.cap = cap;
      const Surface level = make_levels(m, model.character, poses.examples, target).front();
      const Surface* levels[] = {&level};
      DeviationOptions options;
      options.groups.assign(poses.unseen_clip.size(), 0);
      const PosedError error =
          posed_error(deviations(model.character.surface, levels, poses.unseen_clip, options).front());
      Json line = head("figure2", model);
      line["method"] = cap == 0 ? "no cap" : "cap " + std::to_string(cap);
      line["source_influences"] = most_influences(model.character.surface);
      line["triangles"] = triangle_count(level);
      line["most_influences"] = most_influences(level);
      line["mean_influences"] = mean_influences(level);
      line["rms_percent"] = percent(model, error.rms);
      line["max_percent"] = percent(model, error.max);
      print_line(streams.out, line);
    }
  }
}

Json list(const std::vector<Vec3>& points) {
  Json json = Json::array();
  for (const Vec3& x : points) json.push_back({float(x.x()), float(x.y()), float(x.z())});
  return json;
}

Json faces(const Surface& s) {
  Json json = Json::array();
  for (int f = 0; f < s.face_count(); ++f) {
    Json face = Json::array();
    for (const int wedge : s.face(f)) face.push_back(s.wedges[wedge].vertex);
    json.push_back(face);
  }
  return json;
}

// The column at 3,000 triangles: distances, angles between normals, and the surfaces themselves.
void figure4(const Streams& streams) {
  streams.err << "figure 4\n";
  const Model model{"square column", "Square Column", 4, square_column()};
  const PoseSet poses = example_poses(model, 12);
  const int target[] = {3000};
  const Pose bent{"clip bend at its end", sample(model.character.skeleton, model.character.clips[0], 1)};
  for (const std::string& name : kCompared) {
    const Surface level = make_levels(method(name), model.character, poses.examples, target).front();
    const Surface* levels[] = {&level};
    const auto found =
        deviations(model.character.surface, levels, poses.unseen_clip, {.attributes = true}).front();
    std::vector<double> angles;
    for (const Deviation& d : found) angles.insert(angles.end(), d.normal.begin(), d.normal.end());
    const PosedError error = posed_error(found);
    const Spread normal = spread(std::move(angles));
    const double degrees = 180 / std::acos(-1.0);
    Json line = head("figure4", model);
    line["method"] = name;
    line["triangles"] = triangle_count(level);
    line["rms_percent"] = percent(model, error.rms);
    line["max_percent"] = percent(model, error.max);
    line["normal_rms_degrees"] = normal.rms * degrees;
    line["normal_mean_degrees"] = normal.mean * degrees;
    line["normal_p99_degrees"] = normal.p99 * degrees;
    line["pose"] = bent.source;
    line["points"] = list(pose_vertices(level, bent.palette));
    line["faces"] = faces(level);
    print_line(streams.out, line);
  }
}

struct Frame {
  std::string clip;
  double seconds;
  Palette palette;
};

// All clips one after the other, thinned evenly.
std::vector<Frame> frames_of(const Character& character, int count) {
  std::vector<Frame> all, some;
  for (const Clip& clip : character.clips) {
    const int frames = std::max(1, int(clip.duration() * PoseOptions{}.frames_per_second));
    for (int k = 0; k <= frames; ++k) {
      const double t = clip.duration() * k / frames;
      all.push_back({clip.name, t, sample(character.skeleton, clip, t)});
    }
  }
  const size_t n = std::min(all.size(), size_t(count));
  for (size_t i = 0; i < n; ++i) some.push_back(all[i * all.size() / n]);
  return some;
}

// RMS over the frames of an animation, example poses or not, and per_frame's as the line below.
void figure5(const PapersArguments& a, const Streams& streams) {
  constexpr int kFrames = 60, kShare = 20;
  std::vector<Model> models;
  models.push_back({"humanoid", "Human", 9, content("humanoid.glb")});
  models.push_back({"centipede", "Centipede", 5, content("centipede.glb")});
  models.push_back({"square column", "Square Column", 4, square_column(16, 216)});
  add_other(models, a, "mannequiny/mannequiny.glb", "Cheb", 27);
  for (const Model& model : models) {
    streams.err << "figure 5: " << model.name << '\n';
    const Surface& source = model.character.surface;
    const PoseSet poses = example_poses(model, 0);
    const int target[] = {triangle_count(source) / kShare};
    const std::vector<Frame> frames = frames_of(model.character, kFrames);
    std::vector<Pose> all;
    for (const Frame& frame : frames) all.push_back({frame.clip, frame.palette});
    std::vector<Surface> levels(kCompared.size());
    parallel_for(int(levels.size()), [&](int i) {
      levels[i] = make_levels(method(kCompared[i]), model.character, poses.examples, target).front();
    });
    std::vector<const Surface*> surfaces;
    for (const Surface& level : levels) surfaces.push_back(&level);
    auto found = deviations(source, surfaces, all, {.bound = false});
    auto& per_frame = found.emplace_back(all.size());
    const std::vector<Palette> still = {{identity()}};
    parallel_for(int(all.size()), [&](int k) {
      const Surface frame = simplify_frame(source, pose_vertices(source, all[k].palette), target).front();
      const Animated animated[] = {{&frame, still}};
      const DeviationOptions rms_only{.bound = false};
      per_frame[k] = deviations(Animated{&source, {&all[k].palette, 1}}, animated, rms_only).front().front();
    });
    for (size_t m = 0; m < found.size(); ++m) {
      for (size_t k = 0; k < frames.size(); ++k) {
        Json line = head("figure5", model);
        line["method"] = m < kCompared.size() ? kCompared[m] : "per_frame";
        line["triangles"] = target[0];
        line["frame"] = k;
        line["clip"] = frames[k].clip;
        line["seconds"] = frames[k].seconds;
        line["rms_percent"] = percent(model, posed_error({&found[m][k], 1}).rms);
        print_line(streams.out, line);
      }
    }
  }
}

}  // namespace

int papers_command(Args args, const Streams& streams) {
  PapersArguments a;
  CommandLine line("papers", "[options]",
                   "Measures what Landreneau and Schaefer 2009 print in their table and figures.",
                   "skinlod_bench");
  line.word("--characters", "DIR", a.folder, "other people's characters, where they are there");
  line.choice("--part", a.chapter, {"all", "table1", "figure2", "figure4", "figure5"}, "what to measure");
  line.number("--runs", "COUNT", a.runs, 1, 99, "of which the median time counts");
  if (!line.parse(args, streams.out)) return 0;
  const auto wanted = [&](Chapter chapter) { return a.chapter == Chapter::All || a.chapter == chapter; };
  if (wanted(Chapter::Table1)) table1(a, streams);
  if (wanted(Chapter::Figure2)) figure2(a, streams);
  if (wanted(Chapter::Figure4)) figure4(streams);
  if (wanted(Chapter::Figure5)) figure5(a, streams);
  return 0;
}

}  // namespace skinlod
