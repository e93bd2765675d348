// SPDX-License-Identifier: MIT
#include "pipeline/sections.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "runtime/slod.h"

namespace skinlod {
namespace {

// Shaders blend this many matrices a vertex.
constexpr std::array kShaders = {1, 2, 4, 8};
constexpr size_t kKinds = kShaders.size();

const std::vector<ByteInfluence>& influences_of(const Surface& surface, const VertexInfluences& influences,
                                                int wedge) {
  return influences[size_t(surface.wedges[size_t(wedge)].vertex)];
}

// The first shader that is enough for all corners of each face.
std::vector<size_t> shaders_of(const Surface& surface, const VertexInfluences& influences) {
  std::vector<size_t> shaders;
  for (int f = 0; f < surface.face_count(); ++f) {
    size_t& shader = shaders.emplace_back(0);
    for (const int w : surface.face(f)) {
      while (influences_of(surface, influences, w).size() > size_t(kShaders[shader])) ++shader;
    }
  }
  return shaders;
}

// For each shader the one that draws its faces, the same or one for more influences: of all ways to cut the
// four into runs the one that costs least, and of those the one with the fewest runs. `used_by` is zeros, by
// wedge, and is left so.
std::array<size_t, kKinds> cheapest_runs(const Surface& surface, std::span<const int> faces,
                                         std::span<const size_t> shader, std::vector<unsigned>& used_by) {
  for (const int f : faces) {  // a bit for each shader
    for (const int w : surface.face(f)) used_by[size_t(w)] |= 1u << shader[size_t(f)];
  }
  std::array<int, 1 << kKinds> wedges{};
  for (const int f : faces) {
    for (const int w : surface.face(f)) ++wedges[std::exchange(used_by[size_t(w)], 0)];
  }

  const auto cost_of_run = [&](size_t first, size_t last) {
    const unsigned run = (2u << last) - (1u << first);
    std::int64_t vertices = 0;
    int blends = 0;
    for (unsigned bits = 1; bits < wedges.size(); ++bits) {
      if ((bits & run) == 0 || wedges[bits] == 0) continue;
      vertices += wedges[bits];
      for (size_t s = first; s <= last; ++s) {
        if (bits >> s & 1) blends = std::max(blends, kShaders[s]);
      }
    }
    return vertices == 0 ? 0 : vertices * blends + kBlendsPerDraw;
  };
  std::array<size_t, kKinds> best{};
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (unsigned cuts = 0; cuts < 1u << (kKinds - 1); ++cuts) {  // bit s: between shaders s and s + 1
    std::array<size_t, kKinds> drawn_by{};
    std::int64_t cost = 0;
    for (size_t first = 0, last = 0; first < kKinds; first = ++last) {
      while (last + 1 < kKinds && !(cuts >> last & 1)) ++last;
      cost += cost_of_run(first, last);
      std::fill(drawn_by.begin() + std::ptrdiff_t(first), drawn_by.begin() + std::ptrdiff_t(last) + 1, last);
    }
    if (cost < least) least = cost, best = drawn_by;
  }
  return best;
}

// Each face goes to the first section of its run that has room for its joints. `wedges` then has one per
// corner.
std::vector<Section> fill_sections(const Surface& surface, const VertexInfluences& influences,
                                   std::span<const int> faces, int part) {
  std::vector<Section> open;
  for (const int f : faces) {
    std::vector<int> joints;
    size_t most = 0;
    for (const int w : surface.face(f)) {
      const auto& of_wedge = influences_of(surface, influences, w);
      most = std::max(most, of_wedge.size());
      for (const ByteInfluence& i : of_wedge) {
        if (std::ranges::find(joints, i.joint) == joints.end()) joints.push_back(i.joint);
      }
    }
    const auto has_room = [&](const Section& s) {
      const auto fresh = std::ranges::count_if(joints, [&](int j) { return !s.joints.contains(j); });
      return s.joints.size() + size_t(fresh) <= SLOD_MAX_SECTION_JOINTS;
    };
    auto section = std::ranges::find_if(open, has_room);
    if (section == open.end()) section = open.insert(open.end(), {.part = part});
    section->max_influences = std::max(section->max_influences, int(most));
    section->joints.insert(joints.begin(), joints.end());
    for (const int w : surface.face(f)) section->wedges.push_back(w);
  }
  return open;
}

// `place` is -1s, by wedge, and is left so.
void order(Section& s, std::vector<int>& place) {
  std::vector<int> wedges;  // each once
  for (const int w : s.wedges) {
    if (place[size_t(w)] < 0) place[size_t(w)] = int(wedges.size()), wedges.push_back(w);
    s.indices.push_back(unsigned(place[size_t(w)]));
  }
  std::vector<unsigned> remap(wedges.size());
  meshopt_optimizeVertexCache(s.indices.data(), s.indices.data(), s.indices.size(), wedges.size());
  meshopt_optimizeVertexFetchRemap(remap.data(), s.indices.data(), s.indices.size(), wedges.size());
  for (unsigned& i : s.indices) i = remap[i];
  s.wedges.resize(wedges.size());
  for (size_t i = 0; i < wedges.size(); ++i) s.wedges[remap[i]] = wedges[i], place[size_t(wedges[i])] = -1;
}

}  // namespace

std::vector<Section> split(const Surface& surface, const VertexInfluences& influences) {
  const std::vector<size_t> shader = shaders_of(surface, influences);
  std::map<int, std::vector<int>> faces_of;  // by part
  for (int f = 0; f < surface.face_count(); ++f) faces_of[surface.part(f)].push_back(f);

  std::vector<Section> all;
  std::vector<unsigned> used_by(surface.wedges.size(), 0);
  for (const auto& [part, faces] : faces_of) {
    const auto drawn_by = cheapest_runs(surface, faces, shader, used_by);
    std::array<std::vector<int>, kKinds> runs;
    for (const int f : faces) runs[drawn_by[shader[size_t(f)]]].push_back(f);
    for (const std::vector<int>& run : runs) {
      std::ranges::move(fill_sections(surface, influences, run, part), std::back_inserter(all));
    }
  }
  std::ranges::stable_sort(all, {}, [](const Section& s) { return std::pair(s.part, s.max_influences); });
  std::vector<int> place(surface.wedges.size(), -1);
  for (Section& s : all) order(s, place);
  return all;
}

}  // namespace skinlod
