// SPDX-License-Identifier: MIT
#include "pipeline/morphs.h"

#include <algorithm>

#include "pipeline/side_by_side.h"

namespace skinlod {
namespace {

void keep_only(std::vector<MorphOffsets>& lists, const auto& kept) {
  const auto none = [](const MorphOffsets& list) { return list.empty(); };
  for (MorphOffsets& list : lists) std::erase_if(list, [&](const MorphOffset& m) { return !kept(m); });
  if (std::all_of(lists.begin(), lists.end(), none)) lists.clear();
}

}  // namespace

MorphOffsets blend(std::span<const MorphOffset> a, std::span<const MorphOffset> b, double t) {
  MorphOffsets sum;
  const auto morph = [](const MorphOffset& m) { return m.morph; };
  side_by_side(a, b, morph, [&](const MorphOffset* i, const MorphOffset* j) {
    MorphOffset both{i ? i->morph : j->morph, Vec3::Zero()};
    if (i) both.delta += (1 - t) * i->delta;
    if (j) both.delta += t * j->delta;
    sum.push_back(both);
  });
  std::erase_if(sum, [](const MorphOffset& m) { return m.delta.isZero(0); });
  return sum;
}

Vec3 offset_of(std::span<const MorphOffset> offsets, int morph) {
  const auto before = [](const MorphOffset& m, int other) { return m.morph < other; };
  const auto at = std::lower_bound(offsets.begin(), offsets.end(), morph, before);
  return at != offsets.end() && at->morph == morph ? at->delta : Vec3::Zero();
}

Vec3 offset_of(std::span<const MorphOffset> offsets, std::span<const double> weights) {
  Vec3 sum = Vec3::Zero();
  if (weights.empty()) return sum;
  for (const auto& [morph, delta] : offsets) {
    if (weights[morph] != 0) sum += weights[morph] * delta;
  }
  return sum;
}

int morph_count(const Surface& surface) {
  int count = 0;
  for (const auto* lists : {&surface.morphs, &surface.normal_morphs}) {
    for (const MorphOffsets& list : *lists) {
      if (!list.empty()) count = std::max(count, list.back().morph + 1);
    }
  }
  return count;
}

std::vector<double> largest_offsets(const Surface& surface, int count) {
  std::vector<double> largest(size_t(count), 0);
  for (const MorphOffsets& list : surface.morphs) {
    for (const auto& [morph, delta] : list) largest[morph] = std::max(largest[morph], delta.norm());
  }
  return largest;
}

void drop_faint_morphs(Surface& surface, double least, double least_of_target) {
  const std::vector<double> largest = largest_offsets(surface, morph_count(surface));
  const double bar = std::max(least, least_of_target);
  const auto stays = [&](const MorphOffset& m) { return largest[m.morph] > bar; };
  keep_only(surface.normal_morphs, stays);
  keep_only(surface.morphs, [&](const MorphOffset& m) { return stays(m) && m.delta.norm() > least; });
}

void remove_morphs(Character& character) {
  character.morphs.clear();
  character.surface.morphs.clear(), character.surface.normal_morphs.clear();
  for (Clip& clip : character.clips)
    std::erase_if(clip.channels, [](const Channel& c) { return c.path == Path::MorphWeights; });
}

}  // namespace skinlod
