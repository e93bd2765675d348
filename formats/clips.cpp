// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "formats/import.h"
#include "formats/import_any.h"
#include "pipeline/error.h"

namespace skinlod {
namespace {

/// The name without what exporters put before it: "mixamorig:Hips" and "Armature|Hips" are "Hips".
std::string bare(const std::string& name) { return name.substr(name.find_last_of(":|") + 1); }

/// Finds the nodes of a skeleton by name; having none is not having the same. Of several with one name it
/// gives a joint, or else the first.
class NodeIndex {
 public:
  explicit NodeIndex(const Skeleton& skeleton) {
    for (const Joint& joint : skeleton.joints) add(skeleton, joint.node);
    for (int n = 0; n < int(skeleton.nodes.size()); ++n) add(skeleton, n);
  }
  int find(const std::string& name) const {
    if (bare(name).empty()) return -1;
    if (const auto node = exact_.find(name); node != exact_.end()) return node->second;
    if (const auto node = bare_.find(bare(name)); node != bare_.end()) return node->second;
    return -1;
  }

 private:
  void add(const Skeleton& skeleton, int n) {
    const std::string& name = skeleton.nodes[n].name;
    if (bare(name).empty()) return;
    exact_.try_emplace(name, n);
    bare_.try_emplace(bare(name), n);
  }
  std::map<std::string, int> exact_, bare_;
};

/// The character's node for each node of a clip file, or -1. Where two nodes mean the same, the first has it.
std::vector<int> matches(const Skeleton& theirs, const Skeleton& ours) {
  const NodeIndex index(ours);
  std::vector<int> match;
  std::set<int> taken;
  for (const Node& node : theirs.nodes) {
    const int n = index.find(node.name);
    match.push_back(n >= 0 && taken.insert(n).second ? n : -1);
  }
  return match;
}

/// Why no node of a clip file is one of the character's.
const char* mismatch(const Skeleton& theirs, const Skeleton& ours) {
  const auto is_nameless = [](const Node& node) { return bare(node.name).empty(); };
  const auto all_nameless = [&](const Skeleton& skeleton) {
    return std::all_of(skeleton.nodes.begin(), skeleton.nodes.end(), is_nameless);
  };
  if (all_nameless(theirs)) return "its nodes have no names";
  return all_nameless(ours) ? "the character's nodes have no names" : "its nodes have other names";
}

/// How many of our units one of theirs is, by the lengths of the bones that both have; 1 where the lengths
/// are in no constant proportion, as in another body. Only inner bones tell: a root may stand anywhere.
double unit_ratio(const Skeleton& theirs, const Skeleton& ours, const std::vector<int>& match) {
  std::vector<double> ratios;
  for (size_t n = 0; n < match.size(); ++n) {
    const int parent = theirs.nodes[n].parent;
    if (match[n] < 0 || parent < 0 || match[parent] < 0) continue;
    if (ours.nodes[match[n]].parent != match[parent]) continue;
    const double their_length = theirs.nodes[n].rest.translation.norm();
    const double our_length = ours.nodes[match[n]].rest.translation.norm();
    if (their_length > 0 && our_length > 0) ratios.push_back(our_length / their_length);
  }
  if (ratios.size() < 3) return 1;
  std::sort(ratios.begin(), ratios.end());
  const double median = ratios[ratios.size() / 2];
  const auto agree = std::count_if(ratios.begin(), ratios.end(),
                                   [&](double ratio) { return std::abs(ratio / median - 1) < 0.01; });
  const bool constant = 10 * agree >= 9 * std::ptrdiff_t(ratios.size());
  return constant && std::abs(median - 1) > 0.01 ? median : 1;
}

bool has_clip(const Character& character, const std::string& name) {
  return std::any_of(character.clips.begin(), character.clips.end(), [&](auto& c) { return c.name == name; });
}

}  // namespace

std::string free_clip_name(const Character& character, const std::string& name, const std::string& file) {
  std::string candidate = name;
  for (int n = 1; has_clip(character, candidate); ++n) {
    candidate = name + " (" + file + (n == 1 ? "" : " " + std::to_string(n)) + ")";
  }
  return candidate;
}

BoundClips import_clips(const std::string& path, const Skeleton& skeleton) {
  Imported file = import_any(path, Need::ClipsOnly);
  std::vector<Clip>& clips = file.character.clips;
  if (clips.empty()) {
    throw Error(Fault::Input, path + ": no clip: it holds no motion: export it with its animation");
  }
  const Skeleton& theirs = file.character.skeleton;
  const std::vector<int> match = matches(theirs, skeleton);
  const double ratio = unit_ratio(theirs, skeleton, match);

  BoundClips bound{{}, 0, 0, std::move(file.warnings), std::move(file.files_read)};
  for (Clip& clip : clips) {
    Clip ours{clips.size() == 1 ? stem(path) : stem(path) + ":" + clip.name, {}};
    for (Channel& channel : clip.channels) {
      channel.node = match[channel.node];
      // The weights of morphs have one column a morph, and a skeleton does not tell how many there are.
      if (channel.node < 0 || channel.path == Path::MorphWeights) continue;
      if (channel.path == Path::Translation) channel.values *= ratio;
      ours.channels.push_back(std::move(channel));
    }
    const auto all = int(clip.channels.size()), found = int(ours.channels.size());
    bound.channels += all, bound.bound += found;
    warn(bound.warnings, {WarningCode::ClipChannelsUnbound, ours.name, all - found,
                          "they have no names, no node of the character has theirs, or they weigh morphs"});
    if (found > 0) bound.clips.push_back(std::move(ours));
  }
  if (bound.bound == 0) {
    throw Error(Fault::Input, path + ": none of its " + std::to_string(bound.channels) +
                                  " channels moves a node of the character: " + mismatch(theirs, skeleton) +
                                  ": give clips made for this skeleton");
  }
  if (ratio != 1) {
    warn(bound.warnings, {WarningCode::ClipUnitsScaled, stem(path), std::int64_t(bound.clips.size()),
                          "translations multiplied by " + std::to_string(ratio)});
  }
  return bound;
}

}  // namespace skinlod
