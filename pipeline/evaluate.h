// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/closest.h"
#include "pipeline/pose.h"

namespace skinlod {

/// Samples per surface and pose where nothing else is asked for.
inline constexpr int kSamples = 4000;

/// `count` samples, evenly by area at rest.
std::vector<Place> sample_by_area(const Surface& surface, int count);

/// What is looked at, and how closely.
struct DeviationOptions {
  int samples = kSamples;   // per surface and pose; the same samples are taken in all poses
  bool attributes = false;  // compare normals, tangents and uvs at the closest points
  bool bound = true;        // find `Deviation::bound`; else it is the largest distance of a sample
  /// Per pose, a group that it belongs to. Within a group only the largest of the bounds is a near one, which
  /// takes a fraction of the time. Empty: each pose has a near bound.
  std::vector<int> groups{};
};

/// What is between two surfaces in one pose. Entry i of each list is sample i: those of the original first,
/// then those of the level, each against the closest point of the other surface (Metro, Cignoni et al. 1998,
/// in both directions).
struct Deviation {
  std::vector<double> distance;  // metres
  double bound = 0;              // metres: no point of either surface is farther from the other
  // Where attributes are asked for, else empty. A surface without normals is shaded by its faces' own.
  std::vector<double> normal;   // radians between shading normals
  std::vector<double> tangent;  // radians; empty where one has no tangents
  std::vector<double> uv;       // of the first set, in its own unit; empty where one has none
};

/// How far `bound` may lie above the largest distance there is: it is searched until no part of a surface can
/// be farther by more than this share.
inline constexpr double kBoundSlack = 0.1;

/// A surface of triangles and the poses it is looked at in, with its own palettes and morphs.
struct Animated {
  const Surface* surface;
  std::span<const Pose> poses;
};

/// The deviations of each level from `original` in each pose: [level][pose]. All have as many poses, and
/// each has at least one face. Shares nothing with the metrics but skinning. The same for any thread count
/// and CPU.
std::vector<std::vector<Deviation>> deviations(const Animated& original, std::span<const Animated> levels,
                                               const DeviationOptions& options = {});

/// The same where all have the same joints and morphs.
std::vector<std::vector<Deviation>> deviations(const Surface& original,
                                               std::span<const Surface* const> levels,
                                               std::span<const Pose> poses,
                                               const DeviationOptions& options = {});

/// A list of numbers in four.
struct Spread {
  double rms = 0, mean = 0;
  double p99 = 0;  // 99 of 100 are no larger
  double max = 0;
};

/// Zeros for no values.
Spread spread(std::vector<double> values);

/// The distances between two surfaces over all of `poses` together, metres; `max` is the largest bound.
using PosedError = Spread;
PosedError posed_error(std::span<const Deviation> poses);

/// The errors of each level over each of the sets of poses by itself: [level][set].
std::vector<std::vector<PosedError>> posed_errors(const Surface& original,
                                                  std::span<const Surface* const> levels,
                                                  std::span<const std::span<const Pose>> sets,
                                                  DeviationOptions options = {});

/// What each sample follows, and how much: entries of any list, by ascending number, with sum 1 or none.
std::vector<Influences> joints_of(const Surface& surface, std::span<const Place> samples);
std::vector<Influences> materials_of(const Surface& surface, std::span<const Place> samples,
                                     std::span<const Part> parts);

/// The distances that one joint, or one material, has a part in.
struct Share {
  double rms = 0;  // metres, each sample weighted by how much it follows
  double max = 0;  // metres, over the samples that follow it more than any other
};

/// One share for each of `entries`, over all of `poses` together. `follows[i]` belongs to sample i of the
/// deviations.
std::vector<Share> shares(std::span<const Influences> follows, std::span<const Deviation> poses, int entries);

}  // namespace skinlod
