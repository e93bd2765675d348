// SPDX-License-Identifier: MIT
#include "tools/selections.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "pipeline/error.h"
#include "pipeline/kept_joints.h"
#include "tools/suggest.h"

namespace skinlod {
namespace {

using Names = std::vector<std::string>;

constexpr const char* kImportance = "--importance";

// What stands before a pattern, in the order of Importance::Of.
constexpr std::array<std::string_view, 3> kPrefixes = {"", "material:", "color:"};

bool any_matches(const std::string& pattern, const Names& names) {
  return std::any_of(names.begin(), names.end(), [&](auto& name) { return matches(pattern, name); });
}

// `names` are those of what is meant to be picked, `also` what may have been meant instead.
[[noreturn]] void refuse(const std::string& option, const std::string& kind, const std::string& pattern,
                         const Names& names, const Names& also = {}) {
  Names candidates = names;
  candidates.insert(candidates.end(), also.begin(), also.end());
  std::string bare = pattern;
  std::erase(bare, '*');
  const auto meant = closest(bare, candidates);
  throw Error{Fault::Usage, option + ": no " + kind + " is called '" + pattern + "': " +
                                (meant           ? "did you mean '" + *meant + "'?"
                                 : names.empty() ? "the character has no " + kind + "s"
                                                 : "the first of them is '" + names[0] + "'")};
}

Names names_of(const auto& items) {
  Names names;
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

}  // namespace

Importance parse_importance(const std::string& text) {
  const size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0) {
    throw Error{Fault::Usage, std::string(kImportance) + ": '" + text + "' is no selection with a factor: " +
                                  "write head*=4, material:skin=4 or color:r=4"};
  }
  Importance what;
  const char *const first = text.data() + equals + 1, *const last = text.data() + text.size();
  const auto [end, fault] = std::from_chars(first, last, what.factor);
  if (fault != std::errc{} || end != last ||
      !(what.factor >= 1 / kMostImportance && what.factor <= kMostImportance))
    throw Error{Fault::Usage, std::string(kImportance) + ": '" + text + "': a factor is 0.01 to 100"};
  what.pattern = text.substr(0, equals);
  for (size_t of = 1; of < kPrefixes.size(); ++of) {
    if (!what.pattern.starts_with(kPrefixes[of])) continue;
    what.of = Importance::Of(of);
    what.pattern.erase(0, kPrefixes[of].size());
    break;
  }
  const bool is_channel =
      what.pattern.size() == 1 && std::string_view("rgba").find(what.pattern) != std::string_view::npos;
  if (what.of == Importance::Of::Colour && !is_channel) {
    throw Error{Fault::Usage, std::string(kImportance) + ": a colour has no channel '" + what.pattern +
                                  "': give color:r, color:g, color:b or color:a"};
  }
  return what;
}

std::string text(const Importance& what) { return std::string(kPrefixes[size_t(what.of)]) + what.pattern; }

void check_pose_clips(const Character& character, const std::vector<std::string>& wanted) {
  const Names names = names_of(character.clips);
  for (const std::string& name : wanted) {
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    const auto meant = closest(name, names);
    throw Error{Fault::Usage, "--pose-clip: there is no clip '" + name + "': " +
                                  (meant           ? "did you mean '" + *meant + "'?"
                                   : names.empty() ? "the character has no clips"
                                                   : "skinlod inspect lists the clips")};
  }
}

void check_kept_joints(const Skeleton& skeleton, const std::vector<std::string>& patterns) {
  const Names names = joint_labels(skeleton);
  for (const std::string& pattern : patterns) {
    if (!any_matches(pattern, names)) refuse("--keep-joint", "joint", pattern, names);
  }
}

void check_importance(const Character& character, const std::vector<Importance>& selections) {
  const Names joints = joint_labels(character.skeleton), materials = names_of(character.materials);
  Names others;
  for (const std::string& name : materials) others.push_back("material:" + name);
  for (const char* channel : {"color:r", "color:g", "color:b", "color:a"}) others.emplace_back(channel);
  for (const Importance& what : selections) {
    switch (what.of) {
      case Importance::Of::Joints:
        if (!any_matches(what.pattern, joints)) refuse(kImportance, "joint", what.pattern, joints, others);
        break;
      case Importance::Of::Material:
        if (!any_matches(what.pattern, materials)) refuse(kImportance, "material", what.pattern, materials);
        break;
      case Importance::Of::Colour:
        if (character.surface.layout.colour_sets > 0) break;
        throw Error{Fault::Usage, std::string(kImportance) + ": " + text(what) +
                                      ": the character has no colours: paint some, or give a pattern of "
                                      "joints"};
    }
  }
}

}  // namespace skinlod
