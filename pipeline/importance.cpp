// SPDX-License-Identifier: MIT
#include "pipeline/importance.h"

#include <algorithm>
#include <string_view>

#include "pipeline/error.h"
#include "pipeline/kept_joints.h"

namespace skinlod {
namespace {

std::vector<double> following(const Character& character, const std::string& pattern) {
  const std::vector<std::string> labels = joint_labels(character.skeleton);
  std::vector<double> shares;
  for (const Influences& influences : character.surface.influences) {
    double& share = shares.emplace_back(0);
    for (const Influence& i : influences) {
      if (matches(pattern, labels[i.joint])) share += i.weight;
    }
    share = std::min(share, 1.0);
  }
  return shares;
}

// Per vertex the largest of what its wedges have.
std::vector<double> largest_of_wedges(const Surface& surface, const auto& share) {
  std::vector<double> shares(surface.position.size(), 0);
  for (size_t w = 0; w < surface.wedges.size(); ++w) {
    double& largest = shares[surface.wedges[w].vertex];
    largest = std::max(largest, share(w));
  }
  return shares;
}

std::vector<double> drawn_with(const Character& character, const std::string& pattern) {
  return largest_of_wedges(character.surface, [&](size_t w) {
    const int material = character.parts[character.surface.wedges[w].part].material;
    return material >= 0 && matches(pattern, character.materials[material].name) ? 1.0 : 0.0;
  });
}

// Parts without colours are white in the table, which does not select them.
std::vector<double> coloured(const Character& character, const std::string& channel) {
  const Surface& surface = character.surface;
  const size_t column = std::string_view("rgba").find(channel);
  if (channel.size() != 1 || column == std::string_view::npos)
    throw Error(Fault::Usage, "importance: a colour has no channel '" + channel + "': give r, g, b or a");
  return largest_of_wedges(surface, [&](size_t w) {
    if (character.parts[surface.wedges[w].part].has.colour_sets == 0) return 0.0;
    const auto at = surface.layout.colour_at(0) + Eigen::Index(column);
    return std::clamp(surface.attributes(Eigen::Index(w), at), 0.0, 1.0);
  });
}

}  // namespace

std::vector<double> selected(const Character& character, const Importance& what) {
  switch (what.of) {
    case Importance::Of::Joints:
      return following(character, what.pattern);
    case Importance::Of::Material:
      return drawn_with(character, what.pattern);
    case Importance::Of::Colour:
      return coloured(character, what.pattern);
  }
  throw Error(Fault::Ours, "importance: not one of the enumerators");
}

std::vector<double> importance(const Character& character, std::span<const Importance> selections) {
  std::vector<double> factors(selections.empty() ? 0 : character.surface.position.size(), 1.0);
  for (const Importance& what : selections) {
    if (!(what.factor >= 1 / kMostImportance && what.factor <= kMostImportance))
      throw Error(Fault::Usage, "importance: '" + what.pattern + "': a factor is 0.01 to 100");
    const std::vector<double> share = selected(character, what);
    if (std::none_of(share.begin(), share.end(), [](double s) { return s > 0; })) {
      throw Error(Fault::Usage, "importance: '" + what.pattern +
                                    "' selects no vertex: name joints that vertices follow, a material in "
                                    "use or a channel that is painted");
    }
    for (size_t v = 0; v < factors.size(); ++v) factors[v] *= 1 + (what.factor - 1) * share[v];
  }
  return factors;
}

double error_weight(const Surface& surface, std::span<const int> ends) {
  if (surface.importance.empty()) return 1;
  double sum = 0;
  for (const int v : ends) sum += surface.importance[v];
  const double mean = sum / double(ends.size());
  return mean * mean;
}

}  // namespace skinlod
