// SPDX-License-Identifier: MIT
#include "pipeline/evaluate.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/farthest.h"
#include "pipeline/parallel.h"
#include "pipeline/rotation.h"

namespace skinlod {
namespace {

// A surface in one pose with its attributes there: one row per wedge, laid out as in the surface.
struct Dressed {
  Dressed(const Animated& a, int pose, bool with_attributes)
      : shape(*a.surface, pose_vertices(*a.surface, a.palettes[pose])),
        attributes(with_attributes ? pose_attributes(*a.surface, a.palettes[pose]) : Rows()) {}

  PosedSurface shape;
  Rows attributes;
};

double angle(const Vec3& a, const Vec3& b) { return std::abs(atan2_exact(a.cross(b).norm(), a.dot(b))); }

Vec3 face_normal(const PosedSurface& s, int f) {
  const auto& [a, b, c] = s.triangle(f);
  return (b - a).cross(c - a);
}

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
  return face_normal(s.shape, f);
}

void compare_attributes(Deviation& d, const Dressed& from, const Sample& sample, const Dressed& to,
                        const ClosestPoint& there) {
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

void look_from(Deviation& d, const Dressed& from, std::span<const Sample> samples, const Dressed& to,
               bool attributes) {
  int guess = 0;
  for (const Sample& sample : samples) {
    const ClosestPoint there = to.shape.closest(from.shape.at(sample.face, sample.share), guess);
    guess = there.face;
    d.distance.push_back(std::sqrt(there.squared));
    if (attributes) compare_attributes(d, from, sample, to, there);
  }
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

// The bounds of one level in all poses. The pose that is the worst of its group needs a near bound: from one
// such pose to the next both surfaces are cut into ever smaller pieces, first in the pose where the samples
// are the farthest apart. In all other poses the pieces are looked over: they have only to show that they are
// no worse.
class Bounds {
 public:
  Bounds(const Animated& original, const Animated& level, std::vector<Deviation>& found)
      : original_(original), level_(level), found_(found) {}

  void find(const std::vector<int>& groups) {
    std::map<int, size_t> worst;
    const auto group = [&](size_t p) { return groups.empty() ? int(p) : groups[p]; };
    for (size_t p = 0; p < found_.size(); ++p) {
      const auto [it, is_new] = worst.emplace(group(p), p);
      if (!is_new && found_[p].bound > found_[it->second].bound) it->second = p;
    }
    std::vector<size_t> leaders;
    for (const auto& [_, p] : worst) leaders.push_back(p);
    std::stable_sort(leaders.begin(), leaders.end(),
                     [&](size_t a, size_t b) { return found_[a].bound > found_[b].bound; });
    for (const size_t p : leaders) cut(p);
    parallel_for(int(found_.size()), [&](int p) {
      const size_t leader = worst.at(group(size_t(p)));
      if (size_t(p) != leader) look_over(size_t(p), found_[leader].bound / (1 + kBoundSlack));
    });
  }

 private:
  static PosedSurface posed(const Animated& a, size_t p) {
    return PosedSurface(*a.surface, pose_vertices(*a.surface, a.palettes[p]));
  }

  void cut(size_t p) {
    const PosedSurface a = posed(original_, p), b = posed(level_, p);
    double known = found_[p].bound * found_[p].bound;
    if (there_.empty()) there_ = whole(a, b, known), back_ = whole(b, a, known);
    double one = 0, other = 0;
    parallel_for(2, [&](int i) {
      if (i == 0) one = squared_bound(a, b, known, kBoundSlack, there_, &there_);
      if (i == 1) other = squared_bound(b, a, known, kBoundSlack, back_, &back_);
    });
    found_[p].bound = std::sqrt(std::max(one, other));
  }

  void look_over(size_t p, double known) {
    const PosedSurface a = posed(original_, p), b = posed(level_, p);
    found_[p].bound = std::sqrt(std::max(squared_bound(a, b, known * known, kBoundSlack, there_),
                                         squared_bound(b, a, known * known, kBoundSlack, back_)));
  }

  const Animated &original_, &level_;
  std::vector<Deviation>& found_;  // `bound` is the largest distance of a sample until it is found
  Cover there_, back_;
};

}  // namespace

// Sample i lies in the face that holds the middle of the i-th of `count` equal shares of the area, at the
// i-th point of a sequence that fills the unit square evenly (Roberts' R2).
std::vector<Sample> sample_by_area(const Surface& s, int count) {
  std::vector<double> until(size_t(s.face_count()));
  double area = 0;
  for (int f = 0; f < s.face_count(); ++f) {
    const auto [a, b, c] = triangle_vertices(s, f);
    area += (s.position[b] - s.position[a]).cross(s.position[c] - s.position[a]).norm() / 2;
    until[f] = area;
  }
  std::vector<Sample> samples;
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
  const size_t poses = original.palettes.size();
  const auto on_original = sample_by_area(*original.surface, options.samples);
  std::vector<std::vector<Sample>> on_level;
  for (const Animated& level : levels) on_level.push_back(sample_by_area(*level.surface, options.samples));
  std::vector<std::vector<Deviation>> found(levels.size(), std::vector<Deviation>(poses));
  parallel_for(int(poses), [&](int p) {
    const Dressed source(original, p, options.attributes);
    for (size_t l = 0; l < levels.size(); ++l) {
      const Dressed level(levels[l], p, options.attributes);
      Deviation& d = found[l][p];
      look_from(d, source, on_original, level, options.attributes);
      look_from(d, level, on_level[l], source, options.attributes);
      d.bound = largest(d.distance);
    }
  });
  for (size_t l = 0; l < levels.size() && options.bound && poses > 0; ++l)
    Bounds(original, levels[l], found[l]).find(options.groups);
  return found;
}

std::vector<std::vector<Deviation>> deviations(const Surface& original,
                                               std::span<const Surface* const> levels,
                                               std::span<const Pose> poses, const DeviationOptions& options) {
  std::vector<Palette> palettes;
  for (const Pose& pose : poses) palettes.push_back(pose.palette);
  std::vector<Animated> animated;
  for (const Surface* level : levels) animated.push_back({level, palettes});
  return deviations(Animated{&original, palettes}, animated, options);
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

std::vector<Influences> joints_of(const Surface& surface, std::span<const Sample> samples) {
  std::vector<Influences> follows;
  for (const Sample& s : samples) {
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

std::vector<Influences> materials_of(const Surface& surface, std::span<const Sample> samples,
                                     std::span<const Part> parts) {
  std::vector<Influences> follows;
  for (const Sample& s : samples) {
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
