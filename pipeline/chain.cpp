// SPDX-License-Identifier: MIT
#include "pipeline/chain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "pipeline/collapse.h"
#include "pipeline/error.h"
#include "pipeline/kept_joints.h"
#include "pipeline/metrics/articulated.h"
#include "pipeline/metrics/endpoint.h"
#include "pipeline/metrics/pose_independent.h"
#include "pipeline/metrics/rest_pose.h"
#include "pipeline/refine.h"

namespace skinlod {
namespace {

void validate(const LevelTarget& target) {
  const int named = target.ratio.has_value() + target.triangles.has_value() + target.max_error.has_value();
  if (named != 1) throw Error(Fault::Usage, "level: needs one of ratio, triangles and max_error");
  if (target.ratio && !(*target.ratio > 0 && *target.ratio <= 1)) {
    throw Error(Fault::Usage, "level: ratio " + std::to_string(*target.ratio) + " is not in (0, 1]");
  }
  if (target.triangles && *target.triangles < 1)
    throw Error(Fault::Usage, "level: wants at least 1 triangle");
  if (target.max_error && !(*target.max_error > 0))
    throw Error(Fault::Usage, "level: max_error must be above 0");
  if (target.max_influences < 0 || target.max_influences > 8) {
    throw Error(Fault::Usage, "level: max_influences must be 1 to 8, or 0 for no limit");
  }
  if (target.max_joints && target.joint_error)
    throw Error(Fault::Usage, "level: takes one of max_joints and joint_error");
  if (target.max_joints && *target.max_joints < 1) throw Error(Fault::Usage, "level: wants at least 1 joint");
  if (target.joint_error && !(*target.joint_error > 0))
    throw Error(Fault::Usage, "level: joint_error must be above 0");
}

void validate(const ChainOptions& options) {
  for (const LevelTarget& target : options.targets) {
    validate(target);
    if (options.metric != Metric::Articulated && (target.max_joints || target.joint_error))
      throw Error(Fault::Usage, "level: only the articulated metric lets joints leave");
  }
  if (options.refine < 0 || options.refine > kMaxRefineRounds) {
    throw Error(Fault::Usage, "refine: " + std::to_string(options.refine) + " rounds: give 0 to " +
                                  std::to_string(kMaxRefineRounds));
  }
  if (options.weights == WeightRule::Signed && options.metric != Metric::Articulated) {
    throw Error(Fault::Usage, "weights: only the articulated metric solves for weights");
  }
}

double rms_error(const Surface& source, const Surface& level, std::span<const Pose> poses) {
  const Surface* levels[] = {&level};
  return posed_error(deviations(source, levels, poses, {.bound = false}).front()).rms;
}

// What becomes of a level once it is collapsed, under its cap. Level 0 stays what the source is.
using Finish = std::function<Surface(Surface level, int max_influences)>;

// The working state of one chain: the mesh as far as it is collapsed, and the metric's books beside it.
template <CollapseMetric M>
class ChainBuilder {
 public:
  ChainBuilder(const Surface& source, Mesh mesh, M metric, JointLod joints, std::span<const Pose> examples,
               Finish finish)
      : source_(source),
        examples_(examples),
        finish_(std::move(finish)),
        size_(diagonal(source.position)),
        mesh_(std::move(mesh)),
        metric_(std::move(metric)),
        joints_(std::move(joints)) {}

  Level next(const LevelTarget& target, const TrianglesLeft& tell) {
    if (target.max_influences != cap_) {
      cap_ = target.max_influences;
      append(metric_.limit_influences(mesh_, cap_));
    }
    Level level;
    level.max_influences = cap_;
    // That joints leave before the collapse gives errors about 1 % higher than after it, and there are more
    // vertices to solve for. But an error that is to be kept must have them in it.
    if (target.max_error) {
      let_leave(target, level);
      level.reached = collapse_to_error(*target.max_error, tell);
      level.asked = mesh_.triangle_count();
      if (!level.reached) {
        level.reason =
            "the error is above the target before any collapse: allow more influences or a larger error";
      }
    } else {
      level.asked = target.triangles ? *target.triangles
                                     : std::max(1, int(std::floor(*target.ratio * triangle_count(source_))));
      append(collapse(mesh_, metric_, level.asked, tell));
      level.reached = mesh_.triangle_count() <= level.asked;
      if (!level.reached) level.reason = what_holds();
      let_leave(target, level);
    }
    level.steps = history_.size();
    level.surface = mesh_.surface(metric_.influences());
    return level;
  }

  History take_history() { return std::move(history_); }

 private:
  void append(History more) {
    history_.insert(history_.end(), std::make_move_iterator(more.begin()),
                    std::make_move_iterator(more.end()));
  }

  void let_leave(const LevelTarget& target, Level& level) {
    if constexpr (std::same_as<M, ArticulatedMetric>) {
      JointLimit limit{.count = target.max_joints};
      if (target.joint_error) limit.error = *target.joint_error * size_;
      JointLod::Left left = metric_.let_leave(mesh_, joints_, limit);
      level.joints_left = std::move(left.joints);
      append(std::move(left.changes));
    }
  }

  double error_of(const Surface& surface) const { return rms_error(source_, surface, examples_) / size_; }

  Surface finished(Surface level) const { return finish_(std::move(level), cap_); }

  // Collapses a copy to the end, and looks for the longest beginning of that history that is still good
  // enough once it is finished. Finishing takes away a share of the error that hardly changes along the
  // history: each try tells how much more may be allowed before it.
  bool collapse_to_error(double max_error, const TrianglesLeft& tell) {
    constexpr int kTries = 6;
    constexpr double kCaution = 0.99;
    const Surface start = mesh_.surface(metric_.influences());
    const double before = error_of(start), after_it = error_of(finished(start));
    if (after_it > max_error) return false;
    Mesh end = mesh_;
    M metric = metric_;
    History more = collapse(end, metric, 0, tell);
    double allowed = max_error * (after_it > 0 ? std::max(1.0, before / after_it) : 1);
    size_t best = 0;
    for (int t = 0; t < kTries; ++t) {
      const size_t steps = longest_below(allowed, more);
      if (steps <= best && t > 0) break;
      const double error = error_of(finished(after(more, steps)));
      if (error <= max_error) best = std::max(best, steps);
      if (!(error > 0)) break;
      allowed *= kCaution * max_error / error;
    }
    more.resize(best);
    for (const Step& step : more) {
      mesh_.collapse(step.edge, step.position, step.morphs);
      metric_.commit(step.edge, {step.cost, step.position, step.influences});
    }
    append(std::move(more));
    return true;
  }

  Surface after(const History& more, size_t steps) const {
    Mesh trial = mesh_;
    std::vector<Influences> influences = metric_.influences();
    for (size_t i = 0; i < steps; ++i) {
      trial.collapse(more[i].edge, more[i].position, more[i].morphs);
      influences[more[i].edge.kept] = more[i].influences;
    }
    return trial.surface(influences);
  }

  // The error hardly ever falls along a history, so halving finds it.
  size_t longest_below(double allowed, const History& more) const {
    size_t good = 0, bad = more.size() + 1;
    while (bad - good > 1) {
      const size_t middle = good + (bad - good) / 2;
      (error_of(after(more, middle)) <= allowed ? good : bad) = middle;
    }
    return good;
  }

  // Why no edge that is left may be collapsed, counted.
  std::string what_holds() const {
    std::map<std::string, int> reasons;
    const auto edges = mesh_.edges();
    for (const Edge e : edges) {
      const Refusal refusal = mesh_.refusal(e);
      const bool illegal = refusal != Refusal::None && mesh_.refusal(e.turned()) != Refusal::None;
      ++reasons[illegal ? std::string(text(refusal))
                        : "would turn a face over in an example pose or its texture"];
    }
    std::string words = "no legal collapse is left at " + std::to_string(mesh_.triangle_count()) +
                        " triangles: of " + std::to_string(edges.size()) + " edges ";
    for (const auto& [reason, count] : reasons) words += std::to_string(count) + " " + reason + ", ";
    words.resize(words.size() - 2);
    return words;
  }

  const Surface& source_;
  std::span<const Pose> examples_;
  Finish finish_;
  double size_;
  Mesh mesh_;
  M metric_;
  JointLod joints_;
  int cap_ = 0;
  History history_;
};

void count_joints(Level& level, const LevelTarget& target) {
  level.joints = joint_count(level.surface);
  if (!target.max_joints || level.joints <= *target.max_joints) return;
  level.reached = false;
  level.reason += (level.reason.empty() ? "" : "; ") + std::to_string(level.joints) +
                  " joints are left and must stay: allow more, or keep fewer";
}

template <CollapseMetric M>
Chain build(const Surface& source, Mesh mesh, M metric, JointLod joints, const PoseSet& poses,
            const std::vector<LevelTarget>& targets, const Finish& finish, const Progress& progress) {
  const int triangles = std::max(1, triangle_count(source));
  const auto tell = [&](int left) {
    if (progress && left % 256 == 0) progress("collapse", 1 - double(left) / triangles);
  };
  Chain chain;
  {  // the mesh and the metric's books are gone before what finishing takes is there
    ChainBuilder builder(source, std::move(mesh), std::move(metric), std::move(joints), poses.examples,
                         finish);
    for (const LevelTarget& target : targets) chain.levels.push_back(builder.next(target, tell));
    chain.history = builder.take_history();
  }
  for (size_t l = 0; l < targets.size(); ++l) {
    if (progress) progress("fit", double(l) / double(targets.size()));
    Level& level = chain.levels[l];
    level.surface = finish(std::move(level.surface), level.max_influences);
    count_joints(level, targets[l]);
  }
  return chain;
}

Chain build(const Character& character, const Surface& source, const PoseSet& poses,
            const ChainOptions& options, const std::vector<LevelTarget>& targets, const Progress& progress) {
  Mesh mesh(source, options.borders);
  const double size = diagonal(source.position);
  const JointLod joints(character.skeleton, poses.examples, kept_joints(character, options.keep_joints),
                        size);
  std::optional<Original> original;
  const Finish finish = [&](Surface level, int max_influences) {
    if (level.face_count() == source.face_count()) return level;
    if (options.metric == Metric::Articulated && options.refine > 0) {
      if (!original) original.emplace(source);
      level = refined(*original, std::move(level), poses.examples,
                      {.rounds = options.refine,
                       .max_influences = max_influences,
                       .weights = options.weights,
                       .borders = options.borders,
                       .attributes = options.attributes,
                       .byte_weights = options.byte_weights && options.weights == WeightRule::NonNegative});
    }
    const bool important = options.morphs == MorphUse::Important;
    const std::span<const Pose> bind(poses.examples.data(), 1);
    drop_faint_morphs(level, kFaintMorph * size, important ? rms_error(source, level, bind) : 0);
    return level;
  };
  const auto with = [&](auto metric) {
    return build(source, std::move(mesh), std::move(metric), joints, poses, targets, finish, progress);
  };
  switch (options.metric) {
    case Metric::Articulated:
      return with(ArticulatedMetric(mesh, source.influences, poses.examples,
                                    {.weights = options.weights, .attributes = options.attributes}));
    case Metric::PoseIndependent:
      return with(PoseIndependentMetric(mesh, source.influences, poses.examples));
    case Metric::Endpoint:
      return with(EndpointMetric(mesh, source.influences, poses.examples));
    case Metric::RestPose:
      return with(RestPoseMetric(mesh, source.influences));
  }
  throw Error(Fault::Ours, "metric: not one of the enumerators");
}

// A level without a step is the source itself, and has no error.
void measure(Chain& chain, const Surface& source, const PoseSet& poses, const Progress& progress) {
  std::vector<Level*> levels;
  std::vector<const Surface*> surfaces;
  for (Level& level : chain.levels) {
    if (level.steps > 0) levels.push_back(&level), surfaces.push_back(&level.surface);
  }
  if (progress) progress("measure", 0);
  const std::array<std::span<const Pose>, 4> sets = {poses.examples, poses.unseen_clip, poses.unseen_motion,
                                                     poses.morphs};
  const auto errors = posed_errors(source, surfaces, sets);
  for (size_t l = 0; l < errors.size(); ++l) {
    levels[l]->examples = errors[l][0];
    levels[l]->unseen_clip = errors[l][1];
    levels[l]->unseen_motion = errors[l][2];
    levels[l]->morphs = errors[l][3];
  }
  if (progress) progress("measure", 1);
}

}  // namespace

Chain build_chain(const Character& character, const PoseSet& poses, const ChainOptions& options,
                  const Progress& progress) {
  validate(options);
  std::vector<LevelTarget> targets = options.targets;
  if (options.source_level) {
    targets.insert(targets.begin(),
                   {.ratio = 1.0, .max_influences = targets.empty() ? 4 : targets[0].max_influences});
  }
  // Most characters are triangles already, and large ones should not be there twice.
  std::optional<Surface> changed;
  if (!options.importance.empty() || !is_triangulated(character.surface)) {
    changed = triangulated(character.surface);
    changed->importance = importance(character, options.importance);
  }
  const Surface& source = changed ? *changed : character.surface;
  if (progress) progress("quadrics", 0);
  Chain chain = build(character, source, poses, options, targets, progress);
  if (options.measured) measure(chain, source, poses, progress);
  return chain;
}

}  // namespace skinlod
