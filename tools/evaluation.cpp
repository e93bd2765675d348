// SPDX-License-Identifier: MIT
#include "tools/evaluation.h"

#include <algorithm>
#include <array>
#include <map>
#include <ostream>

#include "tools/table.h"

namespace skinlod {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

Json spread_report(std::vector<double> values, double scale) {
  if (values.empty()) return nullptr;
  const Spread s = spread(std::move(values));
  return {{"rms", s.rms * scale}, {"mean", s.mean * scale}, {"p99", s.p99 * scale}, {"max", s.max * scale}};
}

// One list of all the poses' lists.
std::vector<double> together(std::span<const Deviation> poses, std::vector<double> Deviation::*values) {
  std::vector<double> all;
  for (const Deviation& d : poses) all.insert(all.end(), (d.*values).begin(), (d.*values).end());
  return all;
}

void add_attributes(Json& json, std::span<const Deviation> poses) {
  json["normal_degrees"] = spread_report(together(poses, &Deviation::normal), kDegrees);
  json["tangent_degrees"] = spread_report(together(poses, &Deviation::tangent), kDegrees);
  json["uv"] = spread_report(together(poses, &Deviation::uv), 1);
}

// What one surface was measured against, and how.
class Measured {
 public:
  explicit Measured(const Evaluation& e) : e_(e), size_(diagonal(e.original.surface.position)) {
    for (const auto* set : {&e.poses.examples, &e.poses.unseen_clip, &e.poses.unseen_motion, &e.poses.morphs})
      poses_.insert(poses_.end(), set->begin(), set->end());
    follows_ = joints_of(e.original.surface, on_original());
    materials_ = materials_of(e.original.surface, on_original(), e.original.parts);
  }

  Json level(const Candidate& candidate) const {
    const Matched& matched = candidate.matched;
    std::vector<Pose> poses;
    for (const Pose& pose : poses_) poses.push_back(matched.posed(pose));
    const Animated animated{&matched.surface, poses};
    const auto found = deviations({&e_.original.surface, poses_}, {&animated, 1}, e_.options).front();
    const std::span<const Deviation> all = found;
    const size_t clips = e_.poses.unseen_clip.size(), motion = e_.poses.unseen_motion.size();
    const size_t morphs = e_.poses.morphs.size();

    Json json = {{"file", candidate.file},
                 {"lod", candidate.lod < 0 ? Json() : Json(candidate.lod)},
                 {"triangles", matched.surface.face_count()}};
    json["rest"] = error(all.first(1));
    json["clips"] = error(all.subspan(1, clips));
    json["motion"] = error(all.subspan(1 + clips, motion));
    json["morphs"] = error(all.last(morphs));
    json["morphs_missing"] = missing(matched);
    add_attributes(json, all);
    json["by_clip"] = by_clip(all.subspan(1, clips));
    json["by_joint"] = by_joint(matched, all);
    json["by_material"] = by_material(all);
    json["worst"] = worst(json, all);
    json["poses"] = Json::array();
    for (size_t p = 0; p < all.size(); ++p) {
      Json& pose =
          json["poses"].emplace_back(Json{{"name", poses_[p].source}, {"error", error(all.subspan(p, 1))}});
      add_attributes(pose, all.subspan(p, 1));
    }
    return json;
  }

 private:
  std::vector<Place> on_original() const { return sample_by_area(e_.original.surface, e_.options.samples); }

  Json error(std::span<const Deviation> poses) const {
    return poses.empty() ? Json() : error_report(posed_error(poses), size_);
  }

  // The measured targets that the candidate has not: it stands still in their poses.
  Json missing(const Matched& matched) const {
    Json json = Json::array();
    for (const Pose& pose : e_.poses.morphs) {
      const auto& on = pose.morph_weights;
      const int morph = int(std::find(on.begin(), on.end(), 1) - on.begin());
      if (std::ranges::find(matched.morphs, morph) == matched.morphs.end())
        json.push_back(e_.original.morphs[morph].name);
    }
    return json;
  }

  // "clip walk at 0.4 s" is of "walk"; frames of one clip stand together.
  Json by_clip(std::span<const Deviation> poses) const {
    constexpr std::string_view kClip = "clip ";
    const auto clip = [&](size_t p) {
      const std::string& source = poses_[1 + p].source;
      return source.substr(kClip.size(), source.rfind(" at ") - kClip.size());
    };
    std::map<std::string, std::vector<Deviation>> of;
    for (size_t p = 0; p < poses.size(); ++p) of[clip(p)].push_back(poses[p]);
    Json json = Json::array();
    for (const auto& [name, frames] : of) json.push_back({{"name", name}, {"error", error(frames)}});
    return json;
  }

  Json share(const std::string& name, const Share& share) const {
    const double to_percent = size_ > 0 ? 100 / size_ : 0;
    return {{"name", name},
            {"rms_metres", share.rms},
            {"rms_percent", share.rms * to_percent},
            {"max_metres", share.max},
            {"max_percent", share.max * to_percent}};
  }

  // The candidate's samples count for the original's joints that they follow.
  Json by_joint(const Matched& matched, std::span<const Deviation> poses) const {
    std::vector<Influences> follows = follows_;
    for (Influences& influences :
         joints_of(matched.surface, sample_by_area(matched.surface, e_.options.samples))) {
      for (Influence& i : influences) i.joint = matched.joints[i.joint].joint;
      follows.push_back(std::move(influences));
    }
    const Skeleton& skeleton = e_.original.skeleton;
    const std::vector<std::string> labels = joint_labels(skeleton);
    const auto of = shares(follows, poses, int(skeleton.joints.size()));
    Json json = Json::array();
    for (size_t j = 0; j < of.size(); ++j) json.push_back(share(labels[j], of[j]));
    return json;
  }

  // By the original's materials, as the samples on it see the candidate: another's materials may differ.
  Json by_material(std::span<const Deviation> poses) const {
    std::vector<Deviation> seen(poses.begin(), poses.end());
    for (Deviation& d : seen) d.distance.resize(materials_.size());
    const auto of = shares(materials_, seen, int(e_.original.materials.size()));
    Json json = Json::array();
    for (size_t m = 0; m < of.size(); ++m) json.push_back(share(e_.original.materials[m].name, of[m]));
    return json;
  }

  Json worst(const Json& level, std::span<const Deviation> poses) const {
    const auto name_of_worst = [](const Json& list) {
      const auto less = [](const Json& a, const Json& b) { return a["rms_metres"] < b["rms_metres"]; };
      return list.empty() ? ""
                          : std::max_element(list.begin(), list.end(), less)->at("name").get<std::string>();
    };
    const auto rms = [](const Deviation& d) { return posed_error({&d, 1}).rms; };
    const auto pose = std::ranges::max_element(poses, {}, rms) - poses.begin();
    return {{"pose", poses_[size_t(pose)].source},
            {"joint", name_of_worst(level["by_joint"])},
            {"material", name_of_worst(level["by_material"])}};
  }

  const Evaluation& e_;
  double size_;
  std::vector<Pose> poses_;  // the original's
  std::vector<Influences> follows_, materials_;
};

std::string level_name(const Json& level) {
  const std::string file = level["file"];
  return level["lod"].is_null() ? file : file + " LOD" + level["lod"].dump();
}

}  // namespace

Json report(const Evaluation& evaluation) {
  Json json = report_head("evaluation", evaluation.input);
  json["triangles"] = evaluation.original.surface.face_count();
  json["diagonal_metres"] = diagonal(evaluation.original.surface.position);
  json["samples"] = evaluation.options.samples;
  json["poses"] = {{"clips", evaluation.poses.unseen_clip.size()},
                   {"motion", evaluation.poses.unseen_motion.size()},
                   {"morphs", evaluation.poses.morphs.size()}};
  json["warnings"] = warnings_report(evaluation.warnings);
  json["levels"] = Json::array();
  const Measured measured(evaluation);
  for (const Candidate& candidate : evaluation.candidates)
    json["levels"].push_back(measured.level(candidate));
  return json;
}

void print_evaluation(std::ostream& out, const Json& told) {
  out << told["input"].get<std::string>() << ": " << grouped(told["triangles"]) << " triangles, diagonal "
      << rounded(told["diagonal_metres"]) << " m\nmeasured at rest, in " << told["poses"]["clips"]
      << " frames of clips and in " << told["poses"]["motion"] << " range-of-motion poses, ";
  const bool with_morphs = told["poses"]["morphs"] > 0;
  if (with_morphs) out << "with " << told["poses"]["morphs"] << " morph targets one at a time, ";
  out << grouped(told["samples"]) << " points each way\n\n";
  std::vector<std::vector<std::string>> rows = {
      {"", "", "posed", "rest", "frames", "of", "clips", "", "range of", "motion", "normals", "uv"},
      {"level", "triangles", "error", "RMS", "RMS", "mean", "99 %", "max", "RMS", "max", "RMS deg", "RMS"}};
  if (with_morphs) {
    for (size_t line = 0; line < 2; ++line) {
      const auto& title = line == 0 ? std::array{"", "morphs"} : std::array{"RMS", "max"};
      rows[line].insert(rows[line].begin() + 10, title.begin(), title.end());
    }
  }
  for (const Json& level : told["levels"]) {
    const auto add = [&](const std::string& unit, double scale) {
      auto& row = rows.emplace_back();
      const bool first = unit == "%";
      row = {first ? level_name(level) : "", first ? grouped(level["triangles"]) : "", unit};
      const auto cell = [&](const char* set, const std::string& figure) {
        const Json& error = level[set];
        const std::string key = figure + (first ? "_percent" : "_metres");
        row.push_back(error.is_null() ? "-" : rounded(error[key].get<double>() * scale));
      };
      cell("rest", "rms");
      for (const char* figure : {"rms", "mean", "p99", "max"}) cell("clips", figure);
      cell("motion", "rms"), cell("motion", "max");
      if (with_morphs) cell("morphs", "rms"), cell("morphs", "max");
      if (!first) return;
      for (const char* what : {"normal_degrees", "uv"})
        row.push_back(level[what].is_null() ? "-" : rounded(level[what]["rms"]));
    };
    add("%", 1), add("mm", 1000);
  }
  print_table(out, rows);
  out << "\nworst in\n";
  for (const Json& level : told["levels"]) {
    const Json& worst = level["worst"];
    out << "  " << level_name(level) << ": " << worst["pose"].get<std::string>();
    if (worst["joint"] != "") out << "; joint " << worst["joint"].get<std::string>();
    if (worst["material"] != "") out << "; material " << worst["material"].get<std::string>();
    out << '\n';
  }
  for (const Json& level : told["levels"]) {
    const size_t missing = level["morphs_missing"].size();
    if (missing == 0) continue;
    out << level_name(level) << ": has no " << level["morphs_missing"][0].get<std::string>();
    if (missing > 1) out << ", nor " << missing - 1 << " more of the morph targets";
    out << ": measured without\n";
  }
}

void print_csv(std::ostream& out, const Json& told) {
  const auto quoted = [](const std::string& text) {
    std::string cell = "\"";
    for (const char c : text) cell += c == '"' ? "\"\"" : std::string(1, c);
    return cell + '"';
  };
  const auto rms = [](const Json& spread) { return spread.is_null() ? "" : spread["rms"].dump(); };
  out << "file,lod,triangles,pose,rms_metres,mean_metres,p99_metres,max_metres,normal_degrees_rms,"
         "tangent_degrees_rms,uv_rms\n";
  for (const Json& level : told["levels"]) {
    for (const Json& pose : level["poses"]) {
      const Json& error = pose["error"];
      out << quoted(level["file"]) << ',' << (level["lod"].is_null() ? "" : level["lod"].dump()) << ','
          << level["triangles"] << ',' << quoted(pose["name"]) << ',' << error["rms_metres"] << ','
          << error["mean_metres"] << ',' << error["p99_metres"] << ',' << error["max_metres"] << ','
          << rms(pose["normal_degrees"]) << ',' << rms(pose["tangent_degrees"]) << ',' << rms(pose["uv"])
          << '\n';
    }
  }
}

}  // namespace skinlod
