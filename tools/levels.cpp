// SPDX-License-Identifier: MIT
#include "tools/levels.h"

#include <algorithm>
#include <charconv>
#include <climits>
#include <cmath>
#include <cstdio>

#include "pipeline/error.h"
#include "tools/command_line.h"

namespace skinlod {
namespace {

[[noreturn]] void refuse(const std::string& option, const std::string& item, const std::string& fact) {
  throw Error{Fault::Usage, option + ": '" + item + "' " + fact};
}

// The number before the % sign, over 100; nothing where `item` is no percentage.
std::optional<double> share(const std::string& item) {
  if (!item.ends_with('%')) return std::nullopt;
  double percent = 0;
  const char* const last = item.data() + item.size() - 1;
  const auto [end, fault] = std::from_chars(item.data(), last, percent);
  if (fault != std::errc{} || end != last || !std::isfinite(percent)) return std::nullopt;
  return percent / 100;
}

// The shortest percentage that `share` reads back as the same number: 0.07 * 100 is not 7.
std::string percent(double value) {
  std::string digits;
  for (int decimals = 0; decimals <= 18; ++decimals) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*f%%", decimals, value * 100);
    digits = text;
    if (share(digits) == value) break;
  }
  return digits;
}

LevelTarget parse_lod(const std::string& item) {
  if (const auto ratio = share(item)) {
    if (*ratio > 0 && *ratio <= 1) return {.ratio = *ratio};
    refuse("--lods", item, "is out of range: give more than 0% and at most 100% of the triangles");
  }
  if (!item.empty() && item.find_first_not_of("0123456789") == std::string::npos) {
    return {.triangles = int(whole_number("--lods", item, 1, INT_MAX))};
  }
  refuse("--lods", item, "is neither a percentage nor a number of triangles: write 50% or 5000");
}

double parse_error(const std::string& option, const std::string& item) {
  const auto error = share(item);
  if (!error) refuse(option, item, "is no percentage of the diagonal: write 0.2%");
  if (*error > 0 && *error <= 1) return *error;
  refuse(option, item, "is out of range: give more than 0% and at most 100% of the diagonal");
}

// One item for each of the levels, of a list that has one for all or one for each.
std::vector<std::string> for_each_level(const std::string& option, const std::string& what,
                                        const std::string& list, size_t levels) {
  auto all = items(list);
  if (all.size() != 1 && all.size() != levels) {
    throw Error{Fault::Usage, option + ": " + std::to_string(all.size()) + " " + what + " for " +
                                  std::to_string(levels) + " levels: give one for all or one for each"};
  }
  all.resize(levels, std::string(all[0]));
  return all;
}

void refuse_return(const std::string& option, const std::string& before, const std::string& after) {
  refuse(option, after, "after " + before + " would let joints return: list the levels from fine to coarse");
}

void refuse_order(const std::string& option, const LevelTarget& finer, const LevelTarget& coarser) {
  throw Error{Fault::Usage, option + ": " + text(coarser) + " after " + text(finer) +
                                " is finer: list the levels from fine to coarse"};
}

}  // namespace

std::vector<LevelTarget> parse_lods(const std::string& list) {
  std::vector<LevelTarget> targets;
  for (const std::string& item : items(list)) {
    targets.push_back(parse_lod(item));
    if (targets.size() == 1) continue;
    const LevelTarget& finer = targets.end()[-2];
    const LevelTarget& coarser = targets.back();
    if ((finer.ratio && coarser.ratio && *coarser.ratio > *finer.ratio) ||
        (finer.triangles && coarser.triangles && *coarser.triangles > *finer.triangles)) {
      refuse_order("--lods", finer, coarser);
    }
  }
  return targets;
}

std::vector<LevelTarget> parse_max_errors(const std::string& list) {
  std::vector<LevelTarget> targets;
  for (const std::string& item : items(list)) {
    targets.push_back({.max_error = parse_error("--max-error", item)});
    if (targets.size() > 1 && *targets.back().max_error < *targets.end()[-2].max_error) {
      refuse_order("--max-error", targets.end()[-2], targets.back());
    }
  }
  return targets;
}

void set_max_influences(std::vector<LevelTarget>& targets, const std::string& list) {
  const auto caps = for_each_level("--max-influences", "caps", list, targets.size());
  for (size_t level = 0; level < targets.size(); ++level)
    targets[level].max_influences = int(whole_number("--max-influences", caps[level], 1, 8));
}

void set_max_joints(std::vector<LevelTarget>& targets, const std::string& list) {
  const auto counts = for_each_level("--joints-per-lod", "numbers", list, targets.size());
  for (size_t level = 0; level < targets.size(); ++level) {
    targets[level].max_joints = int(whole_number("--joints-per-lod", counts[level], 1, INT_MAX));
    if (level > 0 && *targets[level].max_joints > *targets[level - 1].max_joints)
      refuse_return("--joints-per-lod", counts[level - 1], counts[level]);
  }
}

void set_joint_errors(std::vector<LevelTarget>& targets, const std::string& list) {
  const auto errors = for_each_level("--joint-error", "errors", list, targets.size());
  for (size_t level = 0; level < targets.size(); ++level) {
    targets[level].joint_error = parse_error("--joint-error", errors[level]);
    if (level > 0 && *targets[level].joint_error < *targets[level - 1].joint_error)
      refuse_return("--joint-error", errors[level - 1], errors[level]);
  }
}

void check_order(const std::vector<LevelTarget>& targets, int source_triangles) {
  const auto triangles = [&](const LevelTarget& t) {
    return t.triangles ? double(*t.triangles) : *t.ratio * source_triangles;
  };
  for (size_t level = 1; level < targets.size(); ++level) {
    const LevelTarget &finer = targets[level - 1], &coarser = targets[level];
    if (finer.max_error || coarser.max_error) continue;
    if (triangles(coarser) > triangles(finer)) refuse_order("--lods", finer, coarser);
  }
}

std::optional<std::string> doubt(const std::vector<LevelTarget>& targets, int source_triangles) {
  const bool bare = std::all_of(targets.begin(), targets.end(),
                                [](const LevelTarget& t) { return t.triangles && *t.triangles <= 100; });
  if (targets.empty() || !bare || source_triangles < 1000) return std::nullopt;
  const std::string n = std::to_string(*targets.front().triangles);
  return "--lods: " + n + " is a number of triangles: for a share of the source's write " + n + "%";
}

std::string text(const LevelTarget& target) {
  std::string words = target.ratio       ? percent(*target.ratio)
                      : target.triangles ? std::to_string(*target.triangles) + " triangles"
                                         : "error " + percent(*target.max_error);
  if (target.max_joints) words += " and " + std::to_string(*target.max_joints) + " joints";
  if (target.joint_error) words += " and joint error " + percent(*target.joint_error);
  return words;
}

}  // namespace skinlod
