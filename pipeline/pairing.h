// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <map>
#include <span>
#include <vector>

#include "pipeline/charts.h"
#include "pipeline/closest.h"
#include "pipeline/large_pages.h"
#include "pipeline/neighbourhood.h"
#include "pipeline/skin.h"

namespace skinlod {

/// A place on an original, and one on its level of detail: one of them given, the other the closest to it.
struct Pair {
  Place original, level;
  bool given_on_level;
  float area;  // that the given place stands for, as a share of its surface's, and as it counts there
};

using Pairs = LargeVector<Pair>;

/// A place on a surface, and the share of its area that it stands for.
struct Given {
  Place place;
  double area;
};

/// An original, which must outlive this, and what pairs are found by: made once for all of its levels. Where
/// there is one, the surface itself will do.
struct Original {
  Original(const Surface& surface);
  const Surface& surface;
  Skin skin;
  Neighbourhood faces;
  PosedSurface at_rest;
  LargeVector<Given> places;  // that pairs are given by
  std::vector<int> charts;
  std::vector<SeamLine> seams;
};

/// Whether faces of these vector areas may be sides of one surface: the back of a thin one is not. Faces that
/// meet in a sharp edge are, since a place on the edge is on both.
inline bool look_alike(const Vec3& a, const Vec3& b) {
  const double both = a.dot(b);
  return both > 0 || both > -0.5 * std::sqrt(a.squaredNorm() * b.squaredNorm());
}

/// Pairs given from both sides, at rest: the corners, the middles of the edges and the middle of every face
/// of the original; and of each of the four triangles that `level`'s faces are cut into. They are weighted so
/// that cubics are integrated exactly, and as the original's importance says. Where there are many faces they
/// are not cut, and above 160,000 only corners and middles are paired, which quadratics ask for. A place and
/// a closest face that do not look alike are no pair.
Pairs paired(const Original& original, const Surface& level);

/// Which chart of the original each of the level's is made of: the one where most of its area finds its
/// pairs. Both are given by face. A chart without pairs has none.
std::map<int, int> chart_origins(const std::vector<int>& original, const std::vector<int>& level,
                                 std::span<const Pair> pairs);

/// Where the place that was sought for a pair is now that the original's vertices stand at `there` and the
/// level's at `here`: a walk away from where it was.
Pair found_again(Pair pair, const Neighbourhood& original, std::span<const Vec3> there,
                 const Neighbourhood& level, std::span<const Vec3> here);

/// The pairs of a level before its vertices were moved a little, found again at rest; those whose place on
/// the original is in the chart that the level's chart is made of. Others lie across a seam, or on another
/// layer of clothes.
Pairs paired_in_charts(const Original& original, const Surface& level, Pairs pairs);

}  // namespace skinlod
