// SPDX-License-Identifier: MIT
#include "tests/bench/subject.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "pipeline/error.h"
#include "pipeline/influences.h"
#include "pipeline/repair.h"
#include "tests/shapes.h"
#include "tools/input.h"

namespace skinlod {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

Character mended(Character character) {
  repair(character);
  weld(character);
  return character;
}

bool ends_with_one_of(const std::string& name, const json& suffixes) {
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) { return char(std::tolower(c)); });
  return std::any_of(suffixes.begin(), suffixes.end(),
                     [&](const json& suffix) { return lower.ends_with(suffix.get<std::string>()); });
}

bool contains(const json& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

// The characters of a folder and the folders in it, by name. Files of clips belong to a character.
std::map<std::string, std::function<Character()>> files_in(const fs::path& root, const json& known) {
  std::map<std::string, std::function<Character()>> found;
  json of_others = known["again"];
  for (const auto& [character, clips] : known["clips"].items()) {
    for (const std::string clip : clips)
      of_others.push_back((fs::path(character).parent_path() / clip).generic_string());
  }
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    const std::string path = entry.path().string(),
                      name = entry.path().lexically_relative(root).generic_string();
    if (!entry.is_regular_file() || !ends_with_one_of(name, known["suffixes"]) || contains(of_others, name))
      continue;
    std::vector<std::string> clips;
    for (const std::string clip : known["clips"].value(name, json::array()))
      clips.push_back((entry.path().parent_path() / clip).string());
    found[name] = [path, clips] { return load_character(path, clips); };
  }
  return found;
}

// The points of the surface between two of its wedges, found once for each edge.
class Subdivision {
 public:
  Subdivision(const Surface& source, int n) : source_(source), n_(n) {
    made_ = source;
    made_.morphs.clear(), made_.normal_morphs.clear();
    made_.corners.clear(), made_.face_begin = {0};
    for (int w = 0; w < int(source.wedges.size()); ++w) rows_.push_back(source.attributes.row(w));
  }

  Surface cut() {
    for (int f = 0; f < source_.face_count(); ++f) cut(source_.face(f));
    made_.attributes.resize(Eigen::Index(rows_.size()), source_.attributes.cols());
    for (size_t w = 0; w < rows_.size(); ++w) made_.attributes.row(Eigen::Index(w)) = rows_[w];
    return std::move(made_);
  }

 private:
  // A point by how many of n steps it is towards each corner: what all faces and wedges there agree on.
  using Steps = std::map<int, int>;

  void cut(std::span<const int> face) {
    const auto at = [&](int i, int j) { return wedge(face, {n_ - i - j, i, j}); };
    for (int i = 0; i < n_; ++i) {
      for (int j = 0; i + j < n_; ++j) {
        made_.add_face(std::array{at(i, j), at(i + 1, j), at(i, j + 1)});
        if (i + j + 2 <= n_) made_.add_face(std::array{at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
  }

  int wedge(std::span<const int> face, const std::array<int, 3>& steps) {
    Steps wedges, vertices;
    for (size_t k = 0; k < 3; ++k) {
      if (steps[k] == 0) continue;
      wedges[face[k]] += steps[k];
      vertices[source_.wedges[face[k]].vertex] += steps[k];
    }
    if (wedges.size() == 1) return wedges.begin()->first;
    const auto [place, is_new] = wedge_.emplace(wedges, int(made_.wedges.size()));
    if (is_new) {
      made_.wedges.push_back({vertex(vertices), source_.wedges[face[0]].part});
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(source_.attributes.cols());
      for (const auto& [w, step] : wedges) row += double(step) / n_ * source_.attributes.row(w);
      if (source_.layout.normal) row.segment<3>(source_.layout.normal_at()).normalize();
      if (source_.layout.tangent) row.segment<3>(source_.layout.tangent_at()).normalize();
      rows_.push_back(row);
    }
    return place->second;
  }

  int vertex(const Steps& steps) {
    const auto [place, is_new] = vertex_.emplace(steps, int(made_.position.size()));
    if (is_new) {
      Vec3 x = Vec3::Zero();
      Influences influences;
      int taken = 0;
      for (const auto& [v, step] : steps) {
        taken += step;
        x += double(step) / n_ * source_.position[v];
        influences = blend(influences, source_.influences[v], double(step) / taken);
      }
      made_.position.push_back(x);
      made_.influences.push_back(influences);
    }
    return place->second;
  }

  const Surface& source_;
  int n_;
  Surface made_;
  std::vector<Eigen::RowVectorXd> rows_;
  std::map<Steps, int> vertex_, wedge_;
};

}  // namespace

std::string shared_characters() {
  return (fs::path(SKINLOD_ROOT).parent_path() / "shared/characters").string();
}

std::vector<Subject> subjects(const SubjectOptions& options) {
  const json known = json::parse(std::ifstream(SKINLOD_ROOT "/tools/characters.json"));
  std::vector<Subject> all = {
      {"bending_tube", "shape", [] { return mended(bending_tube(32, 96, 6)); }},
      {"square_column", "shape", [] { return mended(square_column(8, 108)); }}};  // 1/16 of the paper's
  for (const fs::path& root : {fs::path(SKINLOD_ROOT) / "content", fs::path(options.folder)}) {
    if (!fs::is_directory(root)) continue;
    for (auto& [name, make] : files_in(root, known)) {
      const bool deforming = contains(known["deforming"], name);
      all.push_back({name, deforming ? "deforming" : "near_rigid", make});
    }
  }
  const auto unwanted = [&](const Subject& s) {
    const auto in_name = [&](const std::string& word) { return s.name.find(word) != s.name.npos; };
    return !options.only.empty() && std::none_of(options.only.begin(), options.only.end(), in_name);
  };
  std::erase_if(all, unwanted);
  if (all.empty()) throw Error{Fault::Usage, "--only: no character has this in its name"};
  return all;
}

Character load_character(const std::string& path, const std::vector<std::string>& clips) {
  Imported source = import_character(path);
  add_clips(source, clips, {});
  return mended(std::move(source.character));
}

Character with_seams_free(const Character& character) {
  Character free = character;
  free.surface = without_attributes(triangulated(character.surface));
  free.parts = {{.name = "all"}};
  free.morphs.clear();
  return free;
}

Surface subdivided(const Surface& surface, int n) { return Subdivision(triangulated(surface), n).cut(); }

}  // namespace skinlod
