// SPDX-License-Identifier: MIT
#include "tools/report.h"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "runtime/slod.h"
#include "tools/selections.h"

namespace skinlod {
namespace {

template <class T>
Json names(const std::vector<T>& items) {
  Json json = Json::array();
  for (const T& item : items) json.push_back(item.name);
  return json;
}

Json sources(const std::vector<Pose>& poses) {
  Json json = Json::array();
  for (const Pose& pose : poses) json.push_back(pose.source);
  return json;
}

// The targets that move nothing of a level.
Json without_effect(const std::vector<Morph>& morphs, const Surface& level) {
  const std::vector<double> largest = largest_offsets(level, int(morphs.size()));
  Json json = Json::array();
  for (size_t m = 0; m < morphs.size(); ++m) {
    if (!(largest[m] > 0)) json.push_back(morphs[m].name);
  }
  return json;
}

// null where there was no pose to measure in: 0 would read as perfect.
Json error(const PosedError& error, bool measured, double diagonal) {
  return measured ? error_report(error, diagonal) : Json();
}

Json source(const Character& character) {
  const Surface& s = character.surface;
  return {{"triangles", triangle_count(s)},
          {"vertices", s.position.size()},
          {"wedges", s.wedges.size()},
          {"joints", character.skeleton.joints.size()},
          {"max_influences", most_influences(s)},
          {"diagonal_metres", diagonal(s.position)},
          {"parts", character.parts.size()},
          {"materials", character.materials.size()},
          {"morphs", character.morphs.size()},
          {"clips", character.clips.size()}};
}

Json importance(const CookStory& story) {
  Json json = Json::array();
  for (const Importance& what : story.options.chain.importance) {
    const std::vector<double> share = selected(story.cooked.character, what);
    json.push_back({{"select", text(what)},
                    {"factor", what.factor},
                    {"vertices", std::count_if(share.begin(), share.end(), [](double s) { return s > 0; })}});
  }
  return json;
}

Json options(const CookStory& story) {
  const PoseOptions& poses = story.options.poses;
  return {{"metric", kMetricNames[size_t(story.options.chain.metric)]},
          {"refine", story.options.chain.refine},
          {"keep_joints", story.options.chain.keep_joints},
          {"importance", importance(story)},
          {"morphs", kMorphUseNames[size_t(story.options.chain.morphs)]},
          {"source_level", story.options.chain.source_level},
          {"lock_open_borders", story.options.chain.borders == Borders::Locked},
          {"merge_materials", story.options.merge_materials},
          {"poses", poses.from_clips},
          {"rom", poses.range_of_motion},
          {"pose_clips", poses.pose_clips},
          {"unseen_clip_frames", poses.unseen_clip_frames},
          {"unseen_rom", poses.unseen_range_of_motion},
          {"frames_per_second", poses.frames_per_second},
          {"seed", poses.seed},
          {"compress", story.pack.compress}};
}

Json clip_files(const std::vector<ClipFile>& files) {
  Json json = Json::array();
  for (const ClipFile& f : files) {
    json.push_back({{"file", f.name}, {"clips", f.clips}, {"channels", f.channels}, {"bound", f.bound}});
  }
  return json;
}

// What each baseline made of level `i`; nothing for the source itself.
Json baselines(const CookStory& story, size_t i, double size) {
  const PoseSet& poses = story.cooked.poses;
  Json json = Json::object();
  for (size_t b = 0; b < story.cooked.baselines.size() && story.cooked.chain.levels[i].steps > 0; ++b) {
    const BaselineLevel& level = story.cooked.baselines[b][i];
    json[kBaselineNames[size_t(story.options.baselines[b])]] = {
        {"triangles", level.triangles},
        {"error",
         {{"unseen_clip", error(level.unseen_clip, !poses.unseen_clip.empty(), size)},
          {"unseen_motion", error(level.unseen_motion, !poses.unseen_motion.empty(), size)}}}};
  }
  return json;
}

Json joints_left(const Level& level, const Character& character, double size) {
  const std::vector<std::string> labels = joint_labels(character.skeleton);
  Json json = Json::array();
  for (const auto& [joint, cost] : level.joints_left) {
    json.push_back({{"joint", labels[size_t(joint)]},
                    {"cost_metres", cost},
                    {"cost_percent", size > 0 ? 100 * cost / size : 0}});
  }
  return json;
}

Json levels(const CookStory& story) {
  const PoseSet& poses = story.cooked.poses;
  const double size = diagonal(story.cooked.character.surface.position);
  const int first = story.options.chain.source_level ? 0 : 1;
  Json json = Json::array();
  for (size_t i = 0; i < story.cooked.chain.levels.size(); ++i) {
    const Level& level = story.cooked.chain.levels[i];
    json.push_back({{"lod", first + int(i)},
                    {"target", story.target[i]},
                    {"asked_triangles", level.asked},
                    {"triangles", triangle_count(level.surface)},
                    {"reached", level.reached},
                    {"reason", level.reason},
                    {"vertices", level.surface.position.size()},
                    {"wedges", level.surface.wedges.size()},
                    {"influence_cap", level.max_influences},
                    {"max_influences", most_influences(level.surface)},
                    {"joints", level.joints},
                    {"joints_left", joints_left(level, story.cooked.character, size)},
                    {"error",
                     {{"examples", error(level.examples, !poses.examples.empty(), size)},
                      {"unseen_clip", error(level.unseen_clip, !poses.unseen_clip.empty(), size)},
                      {"unseen_motion", error(level.unseen_motion, !poses.unseen_motion.empty(), size)},
                      {"morphs", error(level.morphs, !poses.morphs.empty(), size)}}},
                    {"dropped_morphs", without_effect(story.cooked.character.morphs, level.surface)},
                    {"baselines", baselines(story, i, size)},
                    {"bytes", story.level_bytes[i]},
                    {"glb", story.glb.empty() ? Json() : Json(story.glb[i])}});
  }
  return json;
}

Json parts(const Character& character) {
  struct Tally {
    int triangles = 0, wedges = 0;
  };
  std::vector<Tally> tally(character.parts.size());
  const Surface& s = character.surface;
  for (int f = 0; f < s.face_count(); ++f) tally[size_t(s.part(f))].triangles += int(s.face(f).size()) - 2;
  for (const Wedge& w : s.wedges) ++tally[size_t(w.part)].wedges;
  Json json = Json::array();
  for (size_t i = 0; i < tally.size(); ++i) {
    const int material = character.parts[i].material;
    json.push_back({{"name", character.parts[i].name},
                    {"material", material < 0 ? "" : character.materials[size_t(material)].name},
                    {"triangles", tally[i].triangles},
                    {"wedges", tally[i].wedges}});
  }
  return json;
}

}  // namespace

Json report_head(const char* kind) {
  return {{"schema", "skinlod-report"}, {"version", 1}, {"kind", kind}, {"skinlod", SKINLOD_VERSION}};
}

Json report_head(const char* kind, const std::string& input) {
  Json json = report_head(kind);
  json["input"] = input;
  return json;
}

Json warnings_report(const Warnings& all) {
  Json json = Json::array();
  for (const Warning& w : all) {
    json.push_back({{"code", name(w.code)}, {"part", w.part}, {"count", w.count}, {"detail", w.detail}});
  }
  return json;
}

Json error_report(const PosedError& error, double diagonal) {
  const double to_percent = diagonal > 0 ? 100 / diagonal : 0;
  Json json;
  const auto add = [&](const std::string& name, double metres) {
    json[name + "_metres"] = metres, json[name + "_percent"] = metres * to_percent;
  };
  add("rms", error.rms), add("mean", error.mean), add("p99", error.p99), add("max", error.max);
  return json;
}

std::vector<int> influence_histogram(const Surface& surface) {
  std::vector<int> count;
  for (const Influences& influences : surface.influences) {
    count.resize(std::max(count.size(), influences.size() + 1));
    ++count[influences.size()];
  }
  return count;
}

int most_influences(const Surface& surface) {
  return std::max(0, int(influence_histogram(surface).size()) - 1);
}

Json report(const CookStory& story) {
  Json json = report_head("cook", story.input);
  json["options"] = options(story);
  json["source"] = source(story.cooked.character);
  json["warnings"] = warnings_report(story.warnings);
  json["clip_files"] = clip_files(story.clip_files);
  json["poses"] = {{"examples", sources(story.cooked.poses.examples)},
                   {"unseen_clip", sources(story.cooked.poses.unseen_clip)},
                   {"unseen_motion", sources(story.cooked.poses.unseen_motion)},
                   {"morphs", sources(story.cooked.poses.morphs)}};
  json["levels"] = levels(story);
  json["bytes"] = story.bytes;
  return json;
}

Json report(const SourceStory& story) {
  Json json = report_head("character", story.input);
  json["source"] = source(story.character);
  json["imported_vertices"] = story.imported_vertices;
  json["influence_histogram"] = influence_histogram(story.character.surface);
  json["parts"] = parts(story.character);
  json["materials"] = names(story.character.materials);
  json["clips"] = Json::array();
  for (const Clip& clip : story.character.clips) {
    json["clips"].push_back(
        {{"name", clip.name}, {"seconds", clip.duration()}, {"channels", clip.channels.size()}});
  }
  json["morphs"] = names(story.character.morphs);
  json["warnings"] = warnings_report(story.warnings);
  return json;
}

Json report(const SlodStory& story) {
  const Character& character = story.file.character;
  const double size = story.file.levels.empty() ? 0 : diagonal(story.file.levels.front().surface.position);
  Json json = report_head("slod", story.input);
  slod_header header;  // `file` came from these bytes, so it is there
  std::memcpy(&header, story.bytes.data(), sizeof header);
  char checksum[17];
  std::snprintf(checksum, sizeof checksum, "%016" PRIx64, header.checksum);
  json["format_version"] = header.version;
  json["checksum"] = checksum;
  json["bytes"] = story.bytes.size();
  json["head_bytes"] = header.head_bytes;
  json["joints"] = joint_labels(character.skeleton);
  json["materials"] = names(character.materials);
  json["parts"] = names(character.parts);
  json["morphs"] = names(character.morphs);
  json["diagonal_metres"] = size;
  json["levels"] = Json::array();
  for (const SlodLevel& level : story.file.levels) {
    json["levels"].push_back({{"triangles", triangle_count(level.surface)},
                              {"vertices", level.surface.position.size()},
                              {"wedges", level.surface.wedges.size()},
                              {"influence_cap", level.max_influences},
                              {"joints", joint_count(level.surface)},
                              {"error",
                               {{"rms_metres", level.error_rms},
                                {"max_metres", level.error_max},
                                {"rms_percent", size > 0 ? level.error_rms * 100 / size : 0},
                                {"max_percent", size > 0 ? level.error_max * 100 / size : 0}}},
                              {"bytes", level.bytes}});
  }
  return json;
}

Json report(const std::vector<Format>& formats) {
  Json json = report_head("formats");
  json["formats"] = Json::array();
  for (const Format& f : formats) {
    json["formats"].push_back(
        {{"name", f.name}, {"extensions", f.extensions}, {"reads", f.reads}, {"writes", f.writes}});
  }
  return json;
}

std::string text(const Json& report) {
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace skinlod
