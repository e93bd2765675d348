// SPDX-License-Identifier: MIT
#include "pipeline/farthest_in_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "pipeline/farthest.h"
#include "pipeline/parallel.h"

namespace skinlod {
namespace {

// Covers are not made for distances below this share of the largest that is looked for: where most poses
// allow more, so many pieces would take longer to look over than they save.
constexpr double kFinest = 1.0 / 16;

Sketch::PerPose<std::vector<Vec3>> points_of(const Moving& m, const Sketch::PerPose<size_t>& in) {
  return {m.points(in[0]), m.points(in[1]), m.points(in[2]), m.points(in[3])};
}

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
    in_parallel({[&] { covers_[l].there = cover(a, b, within * within, kBoundSlack); },
                 [&] { covers_[l].back = cover(b, a, within * within, kBoundSlack); }});
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

  // Sketches tell which pieces are in doubt; only a pose that has one is posed as a whole.
  void look_over(std::span<const size_t> poses, bool worst) {
    Sketch::PerPose<size_t> in;  // the last fills up the four
    for (size_t k = 0; k < in.size(); ++k) in[k] = poses[std::min(k, poses.size() - 1)];
    // Squared, m^2: where nothing is asked for there is nothing to find.
    const auto known = [&](size_t l, size_t k) {
      const size_t leader = worst_[l][in[k]];
      if (k >= poses.size() || (leader == in[k]) != worst) return std::numeric_limits<double>::infinity();
      const double bound = worst ? found_[l][leader].bound : found_[l][leader].bound / (1 + kBoundSlack);
      return bound * bound;
    };
    auto points = points_of(original_, in);
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
      const Sketch sketch(*levels_[l].tree, points_of(levels_[l], in), centres);
      doubts_of[l] = {doubts(original, sketch, squares, covers_[l].there),
                      doubts(sketch, original, squares, covers_[l].back)};
    });
    parallel_for(int(poses.size()), [&](int pose) {
      const auto k = size_t(pose);
      std::optional<PosedSurface> a;
      for (size_t l = 0; l < levels_.size(); ++l) {
        double squared = known(l, k);
        if (!std::isfinite(squared)) continue;
        const auto &there = doubts_of[l].there[k], &back = doubts_of[l].back[k];
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

void find_bounds(const Moving& original, std::span<const Moving> levels, const std::vector<int>& groups,
                 std::vector<std::vector<Deviation>>& found) {
  Bounds(original, levels, found).find(groups);
}

}  // namespace skinlod
