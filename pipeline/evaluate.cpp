// SPDX-License-Identifier: MIT
#include "pipeline/evaluate.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/farthest_in_motion.h"
#include "pipeline/moving.h"
#include "pipeline/parallel.h"
#include "pipeline/rotation.h"

namespace skinlod {
namespace {

// A surface in one pose with its attributes there: one row per wedge, laid out as in the surface.
struct Dressed {
  Dressed(const Moving& m, size_t p, bool with_attributes) : shape(m.in(p)) {
    if (with_attributes)
      attributes = pose_attributes(m.surface, m.poses[p].palette, m.poses[p].morph_weights);
  }

  PosedSurface shape;
  Rows attributes;
};

double angle(const Vec3& a, const Vec3& b) { return std::abs(atan2_exact(a.cross(b).norm(), a.dot(b))); }

// Columns [at, at + size) of a posed surface's attributes at a point of it.
template <int size>
Eigen::Matrix<double, size, 1> attribute(const Dressed& s, int f, const Vec3& share, int at) {
  const auto face = s.shape.surface().face(f);
  Eigen::Matrix<double, size, 1> sum = Eigen::Matrix<double, size, 1>::Zero();
  for (int k = 0; k < 3; ++k)
    sum += share[k] * s.attributes.row(face[k]).template segment<size>(at).transpose();
  return sum;
}

Vec3 normal_at(const Dressed& s, int f, const Vec3& share) {
  const AttributeLayout& layout = s.shape.surface().layout;
  if (layout.normal) {
    const Vec3 n = attribute<3>(s, f, share, layout.normal_at());
    if (n.squaredNorm() > 0) return n;
  }
  return s.shape.normal(f);
}

// Two layers of cloth may lie in one place, and the closest point on the wrong one: attributes are those of
// the closest point that faces the same way.
void compare_attributes(Deviation& d, const Dressed& from, const Place& sample, const Dressed& to,
                        const ClosestPoint& closest) {
  const Vec3 up = from.shape.normal(sample.face);
  ClosestPoint there = closest;
  if (to.shape.normal(closest.face).dot(up) < 0) {
    const Vec3 x = from.shape.at(sample.face, sample.share);
    if (const auto facing = to.shape.closest_facing(x, up, closest.face); facing.face >= 0) there = facing;
  }
  d.normal.push_back(
      angle(normal_at(from, sample.face, sample.share), normal_at(to, there.face, there.share)));
  const AttributeLayout &a = from.shape.surface().layout, &b = to.shape.surface().layout;
  if (a.tangent && b.tangent) {
    d.tangent.push_back(angle(attribute<3>(from, sample.face, sample.share, a.tangent_at()),
                              attribute<3>(to, there.face, there.share, b.tangent_at())));
  }
  if (a.uv_sets > 0 && b.uv_sets > 0) {
    d.uv.push_back((attribute<2>(from, sample.face, sample.share, a.uv_at(0)) -
                    attribute<2>(to, there.face, there.share, b.uv_at(0)))
                       .norm());
  }
}

// `near` has, per sample, a face that was near in another pose, or nothing yet: then it is found.
void look_from(Deviation& d, const Dressed& from, std::span<const Place> samples, const Dressed& to,
               std::vector<int>& near, bool attributes) {
  const bool is_first = near.empty();
  int guess = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    const auto& [face, share] = samples[i];
    const ClosestPoint there = to.shape.closest(from.shape.at(face, share), is_first ? guess : near[i]);
    guess = there.face;
    if (is_first) near.push_back(guess);
    d.distance.push_back(std::sqrt(there.squared));
    if (attributes) compare_attributes(d, from, samples[i], to, there);
  }
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

}  // namespace

// Place i lies in the face that holds the middle of the i-th of `count` equal shares of the area, at the
// i-th point of a sequence that fills the unit square evenly (Roberts' R2).
std::vector<Place> sample_by_area(const Surface& s, int count) {
  std::vector<double> until(size_t(s.face_count()));
  double area = 0;
  for (int f = 0; f < s.face_count(); ++f) {
    const auto [a, b, c] = triangle_vertices(s, f);
    area += (s.position[b] - s.position[a]).cross(s.position[c] - s.position[a]).norm() / 2;
    until[f] = area;
  }
  std::vector<Place> samples;
  for (int i = 0; i < count && !until.empty(); ++i) {
    const double at = area * (i + 0.5) / count;
    const auto f = std::min(std::upper_bound(until.begin(), until.end(), at) - until.begin(),
                            std::ptrdiff_t(until.size()) - 1);
    double u = std::fmod(0.5 + 0.7548776662466927 * i, 1.0), v = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    samples.push_back({int(f), Vec3(1 - u - v, u, v)});
  }
  return samples;
}

std::vector<std::vector<Deviation>> deviations(const Animated& original, std::span<const Animated> levels,
                                               const DeviationOptions& options) {
  const size_t poses = original.poses.size();
  const Moving source(original, options.samples);
  std::vector<Moving> moving;
  for (const Animated& level : levels) moving.emplace_back(level, options.samples);
  std::vector<std::vector<Deviation>> found(levels.size(), std::vector<Deviation>(poses));
  struct Near {
    std::vector<int> there, back;
  };
  std::vector<Near> near(levels.size());
  const auto look = [&](size_t p) {
    const Dressed a(source, p, options.attributes);
    parallel_for(int(levels.size()), [&](int l) {
      const Dressed b(moving[l], p, options.attributes);
      Deviation& d = found[l][p];
      look_from(d, a, source.samples, b, near[l].there, options.attributes);
      look_from(d, b, moving[l].samples, a, near[l].back, options.attributes);
      d.bound = largest(d.distance);
    });
  };
  if (poses > 0) look(0);
  parallel_for(int(poses) - 1, [&](int p) { look(size_t(p + 1)); });
  if (options.bound && poses > 0) find_bounds(source, moving, options.groups, found);
  return found;
}

std::vector<std::vector<Deviation>> deviations(const Surface& original,
                                               std::span<const Surface* const> levels,
                                               std::span<const Pose> poses, const DeviationOptions& options) {
  std::vector<Animated> animated;
  for (const Surface* level : levels) animated.push_back({level, poses});
  return deviations(Animated{&original, poses}, animated, options);
}

Spread spread(std::vector<double> values) {
  if (values.empty()) return {};
  Spread s;
  for (const double x : values) s.rms += x * x, s.mean += x, s.max = std::max(s.max, x);
  const auto n = double(values.size());
  s.rms = std::sqrt(s.rms / n), s.mean /= n;
  const auto place = values.begin() + std::ptrdiff_t((values.size() - 1) * 99 / 100);
  std::nth_element(values.begin(), place, values.end());
  s.p99 = *place;
  return s;
}

PosedError posed_error(std::span<const Deviation> poses) {
  std::vector<double> all;
  double bound = 0;
  for (const Deviation& d : poses) {
    all.insert(all.end(), d.distance.begin(), d.distance.end());
    bound = std::max(bound, d.bound);
  }
  PosedError error = spread(std::move(all));
  error.max = bound;
  return error;
}

std::vector<std::vector<PosedError>> posed_errors(const Surface& original,
                                                  std::span<const Surface* const> levels,
                                                  std::span<const std::span<const Pose>> sets,
                                                  DeviationOptions options) {
  std::vector<Pose> all;
  options.groups.clear();
  for (size_t set = 0; set < sets.size(); ++set) {
    all.insert(all.end(), sets[set].begin(), sets[set].end());
    options.groups.resize(all.size(), int(set));
  }
  std::vector<std::vector<PosedError>> errors;
  for (const std::vector<Deviation>& found : deviations(original, levels, all, options)) {
    auto& of_sets = errors.emplace_back();
    auto first = found.begin();
    for (const auto& set : sets) {
      of_sets.push_back(posed_error({first, set.size()}));
      first += std::ptrdiff_t(set.size());
    }
  }
  return errors;
}

std::vector<Influences> joints_of(const Surface& surface, std::span<const Place> samples) {
  std::vector<Influences> follows;
  for (const Place& s : samples) {
    std::map<int, double> weight;
    for (int k = 0; k < 3; ++k) {
      for (const Influence& i : surface.influences[triangle_vertices(surface, s.face)[k]])
        weight[i.joint] += s.share[k] * i.weight;
    }
    auto& influences = follows.emplace_back();
    for (const auto& [joint, w] : weight) influences.push_back({joint, w});
  }
  return follows;
}

std::vector<Influences> materials_of(const Surface& surface, std::span<const Place> samples,
                                     std::span<const Part> parts) {
  std::vector<Influences> follows;
  for (const Place& s : samples) {
    const int material = parts[surface.part(s.face)].material;
    follows.push_back(material < 0 ? Influences{} : Influences{{material, 1.0}});
  }
  return follows;
}

std::vector<Share> shares(std::span<const Influences> follows, std::span<const Deviation> poses,
                          int entries) {
  std::vector<Share> of(size_t(entries), Share{});
  std::vector<double> weight(of.size());
  for (const Deviation& d : poses) {
    for (size_t i = 0; i < d.distance.size(); ++i) {
      const double x = d.distance[i];
      const Influence* most = nullptr;
      for (const Influence& influence : follows[i]) {
        of[influence.joint].rms += influence.weight * x * x;
        weight[influence.joint] += influence.weight;
        if (!most || influence.weight > most->weight) most = &influence;
      }
      if (most) of[most->joint].max = std::max(of[most->joint].max, x);
    }
  }
  for (size_t e = 0; e < of.size(); ++e) of[e].rms = weight[e] > 0 ? std::sqrt(of[e].rms / weight[e]) : 0;
  return of;
}

}  // namespace skinlod
