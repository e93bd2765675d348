// SPDX-License-Identifier: MIT
#include "pipeline/evaluate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "pipeline/farthest.h"
#include "pipeline/parallel.h"
#include "pipeline/rotation.h"
#include "pipeline/skin.h"

namespace skinlod {
namespace {

// A surface that is looked at in all poses, and the points on it that are looked from.
struct Moving {
  Moving(const Animated& animated, int count)
      : surface(*animated.surface),
        poses(animated.poses),
        skin(surface),
        tree(std::make_shared<FaceTree>(surface)),
        samples(sample_by_area(surface, count)) {}

  std::vector<Vec3> points(size_t p) const { return skin.posed(poses[p].palette, poses[p].morph_weights); }
  Sketch::PerPose<std::vector<Vec3>> points(const Sketch::PerPose<size_t>& in) const {
    return {points(in[0]), points(in[1]), points(in[2]), points(in[3])};
  }
  PosedSurface in(size_t p) const { return PosedSurface(tree, points(p)); }

  const Surface& surface;
  std::span<const Pose> poses;
  Skin skin;
  std::shared_ptr<const FaceTree> tree;
  std::vector<Place> samples;
};

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

// Covers are not made for distances below this share of the largest that is looked for: where most poses
// allow more, so many pieces would take longer to look over than they save.
constexpr double kFinest = 1.0 / 16;

// The bounds of all levels in all poses. Per level the one pose of the groups' worst where the surfaces are
// the nearest makes a cover of both: a coarser one would have to be cut again and again in its group. The
// worst pose of each group needs a near bound; the others have only to show that they are no worse.
class Bounds {
 public:
  Bounds(const Moving& original, std::span<const Moving> levels, std::vector<std::vector<Deviation>>& found)
      : original_(original), levels_(levels), found_(found), covers_(levels.size()), worst_(levels.size()) {}

  void find(const std::vector<int>& groups) {
    parallel_for(int(levels_.size()), [&](int l) { cover_level(size_t(l), groups); });
    look_over(true);
    look_over(false);
  }

 private:
  struct Covers {
    Cover there, back;
  };

  void cover_level(size_t l, const std::vector<int>& groups) {
    const std::vector<Deviation>& found = found_[l];
    std::vector<size_t>& worst = worst_[l];
    std::map<int, size_t> worst_of;
    for (size_t p = 0; p < found.size(); ++p) {
      const auto [it, is_new] = worst_of.emplace(groups.empty() ? int(p) : groups[p], p);
      if (!is_new && found[p].bound > found[it->second].bound) it->second = p;
    }
    for (size_t p = 0; p < found.size(); ++p) worst.push_back(worst_of[groups.empty() ? int(p) : groups[p]]);

    const auto by_bound = [&](size_t p, size_t q) { return found[p].bound < found[q].bound; };
    const auto [least, most] = std::ranges::minmax_element(worst, by_bound);
    const PosedSurface a = original_.in(*least), b = levels_[l].in(*least);
    const double within = std::max(found[*least].bound, kFinest * found[*most].bound);
    parallel_for(2, [&](int i) {
      if (i == 0) covers_[l].there = cover(a, b, within * within, kBoundSlack);
      if (i == 1) covers_[l].back = cover(b, a, within * within, kBoundSlack);
    });
  }

  // In the poses that are the worst of their group for a level, or in all others; four by four.
  void look_over(bool worst) {
    std::vector<size_t> poses;
    for (size_t p = 0; p < original_.poses.size(); ++p) {
      if (std::ranges::any_of(worst_, [&](const auto& of) { return (of[p] == p) == worst; }))
        poses.push_back(p);
    }
    parallel_for(int(poses.size() + 3) / 4, [&](int i) {
      const auto four = std::span(poses).subspan(4 * size_t(i));
      look_over(four.first(std::min<size_t>(four.size(), 4)), worst);
    });
  }

  void look_over(std::span<const size_t> poses, bool worst) {
    Sketch::PerPose<size_t> in;  // the last fills up the four
    for (size_t k = 0; k < in.size(); ++k) in[k] = poses[std::min(k, poses.size() - 1)];
    // Squared, m^2: a pose that is not asked for has nothing to find.
    const auto known = [&](size_t l, size_t k) {
      const size_t leader = worst_[l][in[k]];
      if (k >= poses.size() || (leader == in[k]) != worst) return std::numeric_limits<double>::infinity();
      const double bound = worst ? found_[l][leader].bound : found_[l][leader].bound / (1 + kBoundSlack);
      return bound * bound;
    };
    auto points = original_.points(in);
    Sketch::PerPose<Vec3> centres;
    for (size_t k = 0; k < in.size(); ++k) centres[k] = points[k].front();
    const Sketch original(*original_.tree, points, centres);
    struct Doubts {
      Sketch::PerPose<std::vector<int>> there, back;
    };
    std::vector<Doubts> doubts_of(levels_.size());
    parallel_for(int(levels_.size()), [&](int level) {
      const auto l = size_t(level);
      const Sketch::PerPose<double> squares = {known(l, 0), known(l, 1), known(l, 2), known(l, 3)};
      if (std::ranges::none_of(squares, [](double x) { return std::isfinite(x); })) return;
      const Sketch sketch(*levels_[l].tree, levels_[l].points(in), centres);
      doubts_of[l] = {doubts(original, sketch, squares, covers_[l].there),
                      doubts(sketch, original, squares, covers_[l].back)};
    });
    parallel_for(int(poses.size()), [&](int pose) {
      const auto k = size_t(pose);
      std::optional<PosedSurface> a;
      for (size_t l = 0; l < levels_.size(); ++l) {
        double squared = known(l, k);
        if (!std::isfinite(squared)) continue;
        const std::vector<int>&there = doubts_of[l].there[k], &back = doubts_of[l].back[k];
        if (!there.empty() || !back.empty()) {
          if (!a) a.emplace(original_.tree, std::move(points[k]));
          const PosedSurface b = levels_[l].in(in[k]);
          squared = std::max(squared_bound(*a, b, squared, kBoundSlack, covers_[l].there, there),
                             squared_bound(b, *a, squared, kBoundSlack, covers_[l].back, back));
        }
        found_[l][in[k]].bound = std::sqrt(squared);
      }
    });
  }

  const Moving& original_;
  std::span<const Moving> levels_;
  std::vector<std::vector<Deviation>>& found_;  // `bound`: the largest distance of a sample until it is found
  std::vector<Covers> covers_;                  // per level
  std::vector<std::vector<size_t>> worst_;      // per level and pose, the worst pose of its group
};

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
  if (options.bound && poses > 0) Bounds(source, moving, found).find(options.groups);
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
