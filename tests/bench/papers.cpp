// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <set>

#include "pipeline/evaluate.h"
#include "pipeline/influences.h"
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

// The two methods before the paper's have no cap, nor has "our method" of its table; its weights have signs.
// Beside them ours: weights that engines take, without a cap and with the one that is the default.
const std::vector<Method>& compared() {
  const auto named = [](const char* name, const char* like, int cap) {
    Method m = method(like);
    m.name = name, m.cap = cap;
    return m;
  };
  static const std::vector<Method> all = {named("endpoint", "endpoint", 0),
                                          named("pose_independent", "pose_independent", 0),
                                          named("articulated_printed", "articulated_signed", 0),
                                          method("articulated_uncapped"), method("articulated")};
  return all;
}

// One of the paper's models, or what stands in for it.
struct Model {
  std::string name;   // ours
  std::string paper;  // the paper's
  int poses;          // examples, the bind pose among them
  Character character;
};

// Halves the longest edges, no two of one face in one go, until there are `count` triangles: at most one
// less, for a border's edge has one face. Every vertex must have one wedge.
Surface with_edges_halved(Surface s, int count) {
  while (triangle_count(s) + 2 <= count) {
    std::map<std::array<int, 2>, std::vector<int>> faces_at;
    for (int f = 0; f < s.face_count(); ++f) {
      for (int i = 0; i < 3; ++i) {
        const int a = s.face(f)[i], b = s.face(f)[(i + 1) % 3];
        faces_at[{std::min(a, b), std::max(a, b)}].push_back(f);
      }
    }
    struct Side {
      double length;
      std::array<int, 2> ends;
      std::vector<int> faces;
    };
    std::vector<Side> sides;
    const auto at = [&](int wedge) { return s.wedges[wedge].vertex; };
    for (auto& [ends, faces] : faces_at)
      sides.push_back({(s.position[at(ends[0])] - s.position[at(ends[1])]).norm(), ends, std::move(faces)});
    std::stable_sort(sides.begin(), sides.end(),
                     [](const Side& a, const Side& b) { return a.length > b.length; });
    std::vector<int> middle_of(size_t(s.face_count()), -1);  // the new wedge on a side of the face
    std::vector<std::array<int, 2>> halved(middle_of.size());
    int triangles = triangle_count(s);
    for (const Side& side : sides) {
      const auto taken = [&](int f) { return middle_of[f] >= 0; };
      if (triangles + int(side.faces.size()) > count ||
          std::any_of(side.faces.begin(), side.faces.end(), taken))
        continue;
      const int u = at(side.ends[0]), v = at(side.ends[1]);
      s.wedges.push_back({int(s.position.size()), s.wedges[side.ends[0]].part});
      s.position.emplace_back((s.position[u] + s.position[v]) / 2);
      s.influences.push_back(blend(s.influences[u], s.influences[v], 0.5));
      for (const int f : side.faces) middle_of[f] = int(s.wedges.size()) - 1, halved[f] = side.ends;
      triangles += int(side.faces.size());
    }
    Surface finer = s;
    finer.corners.clear(), finer.face_begin = {0};
    for (int f = 0; f < s.face_count(); ++f) {
      const int middle = middle_of[f];
      if (middle < 0) {
        finer.add_face(s.face(f));
        continue;
      }
      for (const int end : halved[f]) {  // the half without this end
        std::array<int, 3> half;
        for (size_t i = 0; i < 3; ++i) half[i] = s.face(f)[i] == end ? middle : s.face(f)[i];
        finer.add_face(half);
      }
    }
    finer.attributes.resize(Eigen::Index(finer.wedges.size()), 0);
    s = std::move(finer);
  }
  return s;
}

// With `count` triangles, flat where the source's are: each is cut into n x n, then the longest edges halved.
Character finer(Character character, int count) {
  const int n = int(std::sqrt(double(count) / triangle_count(character.surface)));
  character.surface = with_edges_halved(subdivided(character.surface, n), count);
  return character;
}

Character content(const std::string& name) {
  return with_seams_free(load_character(SKINLOD_ROOT "/content/" + name));
}

// A character of the folder with the clips beside it, if it is there. True: it is.
bool add_other(std::vector<Model>& models, const PapersArguments& a, const std::string& file,
               const std::string& paper, int poses, std::vector<std::string> clips = {}) {
  const auto path = std::filesystem::path(a.folder) / file;
  if (!std::filesystem::exists(path)) return false;
  for (std::string& clip : clips) clip = (path.parent_path() / clip).string();
  models.push_back(
      {file.substr(0, file.find('/')), paper, poses, with_seams_free(load_character(path, clips))});
  return true;
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

// Connected pieces, each of which keeps a triangle or, closed, four: what a hierarchy cannot go below.
int pieces(const Surface& surface) {
  std::vector<int> parent(surface.position.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (int f = 0; f < surface.face_count(); ++f) {
    const auto [a, b, c] = triangle_vertices(surface, f);
    parent[root(a)] = root(b), parent[root(b)] = root(c);
  }
  std::set<int> roots;
  for (int f = 0; f < surface.face_count(); ++f) roots.insert(root(triangle_vertices(surface, f)[0]));
  return int(roots.size());
}

// Time to the hierarchy of 70 polygons, with what it takes to begin.
void table1(const PapersArguments& a, const Streams& streams) {
  std::vector<Model> models;
  models.push_back({"centipede", "Centipede", 5, finer(content("centipede.glb"), 206672)});
  add_other(models, a, "mannequiny/mannequiny.glb", "Cheb", 27);
  add_other(models, a, "makehuman_female/mh_female.glb", "Lion", 33);
  models.push_back({"square column", "Square Column", 4, square_column()});
  constexpr int kHuman = 240448;
  models.push_back({"humanoid", "Human", 9, finer(content("humanoid.glb"), kHuman)});
  if (add_other(models, a, "arnaud/arnaud.fbx", "Human", 9, {"crossarms.fbx", "run.fbx", "walk.fbx"}))
    models.back().character = finer(std::move(models.back().character), kHuman);
  for (const Model& model : models) {
    streams.err << "table 1: " << model.name << '\n';
    const PoseSet poses = example_poses(model, 0);
    const int target[] = {70};
    for (const Method& m : compared()) {
      Surface level;
      const Cost cost =
          cost_of(a.runs, [&] { level = make_levels(m, model.character, poses.examples, target).front(); });
      Json line = head("table1", model);
      line["method"] = m.name;
      line["examples"] = poses.examples.size();
      line["pieces"] = pieces(model.character.surface);
      line["triangles"] = triangle_count(level);
      line["cpu_seconds"] = cost.cpu_seconds;
      print_line(streams.out, line);
    }
  }
}

// The same share of the triangles as the paper's 3,000 of 13,334, with and without a cap. That count is
// Cheb's in the table, so the poses are as many too.
void figure2(const PapersArguments& a, const Streams& streams) {
  constexpr int kPoses = 27;
  std::vector<Model> models;
  models.push_back({"humanoid", "Lion", kPoses, content("humanoid.glb")});
  models.push_back({"centipede", "Lion", kPoses, content("centipede.glb")});
  add_other(models, a, "mannequiny/mannequiny.glb", "Lion", kPoses);
  add_other(models, a, "makehuman_female/mh_female.glb", "Lion", kPoses);
  struct Way {
    const char* like;
    int cap;
  };
  constexpr Way kWays[] = {{"articulated_signed", 0},
                           {"articulated_signed", 5},
                           {"articulated", 0},
                           {"articulated", 5},
                           {"articulated", 4}};
  for (const Model& model : models) {
    streams.err << "figure 2: " << model.name << '\n';
    const PoseSet poses = example_poses(model, 12);
    const int target[] = {triangle_count(model.character.surface) * 3000 / 13334};
    for (const Way& way : kWays) {
      Method m = method(way.like);
      m.cap = way.cap;
      const Surface level = make_levels(m, model.character, poses.examples, target).front();
      const Surface* levels[] = {&level};
      DeviationOptions options;
      options.groups.assign(poses.unseen_clip.size(), 0);
      const PosedError error =
          posed_error(deviations(model.character.surface, levels, poses.unseen_clip, options).front());
      Json line = head("figure2", model);
      line["method"] = way.like;
      line["cap"] = way.cap;
      line["examples"] = poses.examples.size();
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

// To the micrometre: for pictures.
Json list(const std::vector<Vec3>& points) {
  const auto rounded = [](double x) { return std::round(x * 1e6) / 1e6; };
  Json json = Json::array();
  for (const Vec3& x : points) json.push_back({rounded(x.x()), rounded(x.y()), rounded(x.z())});
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

// Whether the pose is one that was solved for.
bool is_example(const Palette& palette, std::span<const Pose> examples) {
  const auto same = [&](const Pose& example) {
    for (size_t j = 0; j < palette.size(); ++j)
      if (!palette[j].isApprox(example.palette[j], 1e-9)) return false;
    return true;
  };
  return std::any_of(examples.begin(), examples.end(), same);
}

// The column bent and twisted at once, which no clip of its does.
Pose bent_and_twisted(const Character& column) {
  Clip both = column.clips[0];
  const Clip& twist = column.clips[1];
  const auto at = [](Rows& values, Eigen::Index key) {
    return Eigen::Map<Eigen::Quaterniond>(values.row(key).data());
  };
  for (size_t j = 0; j < both.channels.size(); ++j) {
    Rows turned = twist.channels[j].values;
    for (Eigen::Index key = 0; key < turned.rows(); ++key) {
      auto bend = at(both.channels[j].values, key);
      bend = bend * at(turned, key);
    }
  }
  return {"bent and twisted", sample(column.skeleton, both, 0.6)};
}

// The column at 3,000 triangles: distances, angles between normals, and the surfaces themselves. A normal
// more than 45 degrees off is one of the next side, closest to a sample beside an edge of the column: of
// those only the share is told apart, for it drowns what a side's normals do among themselves.
void figure4(const Streams& streams) {
  streams.err << "figure 4\n";
  const Model model{"square column", "Square Column", 4, square_column()};
  const Surface& source = model.character.surface;
  const PoseSet poses = example_poses(model, 12);
  const int target[] = {3000};
  const Pose bent = bent_and_twisted(model.character);
  const double degrees = 180 / std::acos(-1.0);
  std::vector<Pose> measured = poses.unseen_clip;
  measured.push_back(bent);
  const auto shown = [&](const std::string& name, const Surface& surface) {
    Json line = head("figure4", model);
    line["method"] = name;
    line["triangles"] = triangle_count(surface);
    line["pose"] = bent.source;
    line["example"] = is_example(bent.palette, poses.examples);
    line["points"] = list(pose_vertices(surface, bent.palette));
    line["faces"] = faces(surface);
    return line;
  };
  print_line(streams.out, shown("original", source));
  for (const Method& m : compared()) {
    const Surface level = make_levels(m, model.character, poses.examples, target).front();
    const Surface* levels[] = {&level};
    const auto found = deviations(source, levels, measured, {.attributes = true}).front();
    const std::span frames = std::span(found).first(poses.unseen_clip.size());
    const PosedError error = posed_error(frames);
    std::vector<double> angles;
    for (const Deviation& d : frames) angles.insert(angles.end(), d.normal.begin(), d.normal.end());
    const auto beyond = [&](double angle) { return angle * degrees > 45; };
    const double all = double(angles.size());
    const Spread normal = spread(angles);
    const double apart = double(std::erase_if(angles, beyond)) / all;
    std::vector<double> as_shown = found.back().normal;
    std::erase_if(as_shown, beyond);
    Json line = shown(m.name, level);
    line["measured_poses"] = frames.size();
    line["rms_percent"] = percent(model, error.rms);
    line["max_percent"] = percent(model, error.max);
    line["normal_rms_degrees"] = normal.rms * degrees;
    line["normal_mean_degrees"] = normal.mean * degrees;
    line["normal_p99_degrees"] = normal.p99 * degrees;
    line["normal_beyond_45_percent"] = 100 * apart;
    line["normal_within_45_rms_degrees"] = spread(std::move(angles)).rms * degrees;
    line["shown_rms_percent"] = percent(model, posed_error(std::span(found).last(1)).rms);
    line["shown_normal_within_45_rms_degrees"] = spread(std::move(as_shown)).rms * degrees;
    print_line(streams.out, line);
  }
}

struct Frame {
  std::string clip;
  double seconds;
  Palette palette;
};

// All clips one after the other, thinned evenly; at the times that example poses are chosen from.
std::vector<Frame> frames_of(const Character& character, int count) {
  std::vector<Frame> all, some;
  for (const Clip& clip : character.clips) {
    const double rate = PoseOptions{}.frames_per_second;
    for (int k = 0; (k - 1) / rate < clip.duration() - 1e-6; ++k) {
      const double t = std::min(k / rate, clip.duration());
      all.push_back({clip.name, t, sample(character.skeleton, clip, t)});
    }
  }
  const size_t n = std::min(all.size(), size_t(count));
  for (size_t i = 0; i < n; ++i) some.push_back(all[i * all.size() / n]);
  return some;
}

// RMS over the frames of an animation, each told whether it is an example, and per_frame's as the line below.
void figure5(const PapersArguments& a, const Streams& streams) {
  constexpr int kFrames = 60, kShare = 20;
  std::vector<Model> models;
  models.push_back({"humanoid", "Human", 9, content("humanoid.glb")});
  models.push_back({"centipede", "Centipede", 5, content("centipede.glb")});
  models.push_back({"square column", "Square Column", 4, square_column(16, 216)});
  add_other(models, a, "mannequiny/mannequiny.glb", "Cheb", 27);
  add_other(models, a, "makehuman_female/mh_female.glb", "Lion", 33);
  for (const Model& model : models) {
    streams.err << "figure 5: " << model.name << '\n';
    const Surface& source = model.character.surface;
    const PoseSet poses = example_poses(model, 0);
    const int target[] = {triangle_count(source) / kShare};
    const std::vector<Frame> frames = frames_of(model.character, kFrames);
    std::vector<Pose> all;
    for (const Frame& frame : frames) all.push_back({frame.clip, frame.palette});
    std::vector<Surface> levels(compared().size());
    parallel_for(int(levels.size()), [&](int i) {
      levels[i] = make_levels(compared()[i], model.character, poses.examples, target).front();
    });
    std::vector<const Surface*> surfaces;
    for (const Surface& level : levels) surfaces.push_back(&level);
    auto found = deviations(source, surfaces, all, {.bound = false});
    auto& per_frame = found.emplace_back(all.size());
    std::vector<std::vector<int>> triangles(found.size(), std::vector<int>(all.size()));
    for (size_t m = 0; m < levels.size(); ++m)
      std::fill(triangles[m].begin(), triangles[m].end(), triangle_count(levels[m]));
    const Pose still{"bind", {identity()}};
    parallel_for(int(all.size()), [&](int k) {
      const Surface frame = simplify_frame(source, pose_vertices(source, all[k].palette), target).front();
      triangles.back()[k] = triangle_count(frame);
      const Animated animated[] = {{&frame, {&still, 1}}};
      const DeviationOptions rms_only{.bound = false};
      per_frame[k] = deviations(Animated{&source, {&all[k], 1}}, animated, rms_only).front().front();
    });
    for (size_t m = 0; m < found.size(); ++m) {
      for (size_t k = 0; k < frames.size(); ++k) {
        Json line = head("figure5", model);
        line["method"] = m < levels.size() ? compared()[m].name : "per_frame";
        line["examples"] = poses.examples.size();
        line["triangles"] = triangles[m][k];
        line["frame"] = k;
        line["clip"] = frames[k].clip;
        line["seconds"] = frames[k].seconds;
        line["example"] = is_example(frames[k].palette, poses.examples);
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
