// SPDX-License-Identifier: MIT
#include "pipeline/pairing.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <utility>

#include "pipeline/importance.h"
#include "pipeline/parallel.h"

namespace skinlod {
namespace {

// Where places would be more than these, which is millions in all poses, the lattice is a coarser one: of 225
// thousand triangles it saves a fifth of the time of fitting, and levels are as near.
constexpr int kMostPlaces = 480000;

// Parts of a triangle's area at its corners, the middles of its edges and its own.
struct Rule {
  double corner, edge, middle;
};

// They integrate cubics and quadratics exactly.
constexpr Rule kCubic{1.0 / 20, 2.0 / 15, 9.0 / 20}, kQuadratic{1.0 / 12, 0, 3.0 / 4};

// A place in every face, and its part of the face's area.
struct InFace {
  Vec3 share;
  double part;
};

// The places of the rule in each of the n x n triangles that a face is cut into.
std::vector<InFace> lattice(int n, const Rule& rule) {
  using Steps = std::array<int, 3>;  // towards each corner, of 6n
  std::map<Steps, double> parts;
  const auto add_triangle = [&](const Steps& a, const Steps& b, const Steps& c) {
    Steps middle{};
    for (const auto& [from, to] : {std::pair(&a, &b), std::pair(&b, &c), std::pair(&c, &a)}) {
      Steps half{};
      for (size_t k = 0; k < 3; ++k) half[k] = ((*from)[k] + (*to)[k]) / 2, middle[k] += (*from)[k] / 3;
      parts[*from] += rule.corner;
      if (rule.edge > 0) parts[half] += rule.edge;
    }
    parts[middle] += rule.middle;
  };
  const auto corner = [&](int i, int j) { return Steps{6 * (n - i - j), 6 * i, 6 * j}; };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      add_triangle(corner(i, j), corner(i + 1, j), corner(i, j + 1));
      if (i + j + 2 <= n) add_triangle(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
    }
  }
  std::vector<InFace> places;
  for (const auto& [at, part] : parts)
    places.push_back({Vec3(at[0], at[1], at[2]) / (6.0 * n), part / (n * n)});
  return places;
}

// Appends what `body(begin, end, to)` puts into `to` for each run, in the order of the items.
template <class List>
void gather(List& all, size_t count, const auto& body) {
  std::vector<List> runs((count + kRun - 1) / kRun);
  for_each_run(count, [&](size_t begin, size_t end) {
    runs[begin / kRun].reserve(end - begin);
    body(begin, end, runs[begin / kRun]);
  });
  std::vector<size_t> start;
  size_t size = all.size();
  for (const List& run : runs) start.push_back(size), size += run.size();
  all.resize(size);
  for_each_run(count, [&](size_t begin, size_t) {
    const List run = std::move(runs[begin / kRun]);
    std::ranges::copy(run, all.begin() + std::ptrdiff_t(start[begin / kRun]));
  });
}

// The lattice of cubics in n x n triangles, or the finest that makes few enough places: there are three for
// each triangle.
std::vector<InFace> lattice_for(int faces, int n) {
  const auto too_many = [&] { return faces > kMostPlaces / (3 * n * n); };
  if (too_many()) n = 1;
  return lattice(n, too_many() ? kQuadratic : kCubic);
}

// The places of a lattice in every face. What faces share, on an edge or at a vertex, is one place: it lies
// in the first of them, and stands for its part of all.
LargeVector<Given> lattice_places(const Neighbourhood& faces, std::span<const Vec3> points, int n) {
  std::vector<double> area(size_t(faces.face_count()));
  for_each_run(area.size(), [&](size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) area[f] = faces.vector_area(points, int(f)).norm();
  });
  const double total = std::accumulate(area.begin(), area.end(), 0.0);
  // Of all faces that have the place of face `f`, or nothing where `f` is not the first.
  const auto area_around = [&](int f, const Vec3& share) {
    std::array<int, 3> on{};
    size_t count = 0;
    for (int k = 0; k < 3; ++k) {
      if (share[k] > 0) on[count++] = faces.vertices(f)[k];
    }
    if (count == 3) return area[f];
    double sum = 0;
    for (const int g : faces.faces_around(on[0])) {
      const auto& its = faces.vertices(g);
      if (!(area[g] > 0) || (count == 2 && std::find(its.begin(), its.end(), on[1]) == its.end())) continue;
      if (g < f) return 0.0;
      sum += area[g];
    }
    return sum;
  };
  const std::vector<InFace> in_face = lattice_for(faces.face_count(), n);
  LargeVector<Given> all;
  gather(all, area.size(), [&](size_t begin, size_t end, LargeVector<Given>& places) {
    for (int f = int(begin); f < int(end); ++f) {
      if (!(area[f] > 0)) continue;
      for (const auto& [share, part] : in_face) {
        if (const double its = area_around(f, share); its > 0)
          places.push_back({{f, share}, part * its / total});
      }
    }
  });
  return all;
}

}  // namespace

Original::Original(const Surface& s)
    : surface(s),
      skin(s),
      faces(s),
      at_rest(s, s.position),
      places(lattice_places(faces, s.position, 1)),
      charts(skinlod::charts(s)),
      seams(seam_lines(s, faces)) {}

Pairs paired(const Original& original, const Surface& level) {
  const PosedSurface at_rest(level, level.position);
  const Neighbourhood of_level(level);
  Pairs pairs;
  const auto pair_up = [&](const LargeVector<Given>& places, bool on_level) {
    const PosedSurface &from = on_level ? at_rest : original.at_rest,
                       &to = on_level ? original.at_rest : at_rest;
    const auto pair = [&](const Given& given, int& guess) {
      const ClosestPoint there = to.closest(from.at(given.place.face, given.place.share), guess);
      guess = there.face;
      const Place sought{there.face, there.share};
      const Place &a = on_level ? sought : given.place, &b = on_level ? given.place : sought;
      const bool alike = look_alike(original.at_rest.normal(a.face), at_rest.normal(b.face));
      const double weight = alike ? error_weight(original.surface, original.faces.vertices(a.face)) : 0;
      return Pair{a, b, on_level, float(given.area * weight)};
    };
    gather(pairs, places.size(), [&](size_t begin, size_t end, Pairs& some) {
      int guess = 0;  // places of a run are near each other: a search begins where the one before it ended
      for (size_t i = begin; i < end; ++i) {
        if (const Pair p = pair(places[i], guess); p.area > 0) some.push_back(p);
      }
    });
  };
  const LargeVector<Given> of_its_own = lattice_places(of_level, level.position, 2);
  pairs.reserve(original.places.size() + of_its_own.size());
  pair_up(original.places, false);
  pair_up(of_its_own, true);
  return pairs;
}

std::map<int, int> chart_origins(const std::vector<int>& original, const std::vector<int>& level,
                                 std::span<const Pair> pairs) {
  std::map<std::pair<int, int>, double> shared;
  for (const Pair& pair : pairs) shared[{level[pair.level.face], original[pair.original.face]}] += pair.area;
  std::map<int, std::pair<double, int>> most;
  for (const auto& [both, area] : shared) {
    auto& best = most[both.first];
    if (area > best.first) best = {area, both.second};
  }
  std::map<int, int> origins;
  for (const auto& [chart, best] : most) origins[chart] = best.second;
  return origins;
}

Pair found_again(Pair pair, const Neighbourhood& original, std::span<const Vec3> there,
                 const Neighbourhood& level, std::span<const Vec3> here) {
  if (pair.given_on_level) {
    pair.original = original.closest(there, level.at(here, pair.level), pair.original.face);
  } else {
    pair.level = level.closest(here, original.at(there, pair.original), pair.level.face);
  }
  return pair;
}

Pairs paired_in_charts(const Original& original, const Surface& level, Pairs pairs) {
  const Neighbourhood faces(level);
  for_each_run(pairs.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      pairs[i] = found_again(pairs[i], original.faces, original.surface.position, faces, level.position);
  });
  const std::vector<int> ours = charts(level);
  const std::map<int, int> origins = chart_origins(original.charts, ours, pairs);
  std::erase_if(pairs, [&](const Pair& pair) {
    return original.charts[pair.original.face] != origins.at(ours[pair.level.face]);
  });
  return pairs;
}

}  // namespace skinlod
