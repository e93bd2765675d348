// SPDX-License-Identifier: MIT
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <random>

#include "pipeline/clip_frames.h"
#include "pipeline/error.h"
#include "pipeline/parallel.h"
#include "pipeline/pose.h"
#include "pipeline/rotation.h"

namespace skinlod {
namespace {

constexpr int kMostPoints = 500;    // of a posed surface that are compared
constexpr double kSamePose = 1e-6;  // of the diagonal: poses nearer than this are one pose

std::string seconds(double time) {
  char digits[64];
  const auto end = std::to_chars(digits, digits + sizeof digits, time, std::chars_format::fixed, 4);
  return end.ec == std::errc() ? std::string(digits, end.ptr) : "?";
}

Pose pose_at(const Character& character, const ClipFrame& frame) {
  return {"clip " + frame.clip->name + " at " + seconds(frame.time) + " s",
          sample(character.skeleton, *frame.clip, frame.time),
          sample_morph_weights(character.morphs, *frame.clip, frame.time)};
}

// Some points of the posed surface about their centroid, one a column.
struct Cloud {
  Eigen::Matrix3Xd points;
  double square = 0;  // the sum of the squared lengths
};

// Every so many-th vertex, so that all parts are heard whatever their order.
std::vector<int> compared_vertices(const Surface& surface) {
  const int vertices = int(surface.position.size()), count = std::min(vertices, kMostPoints);
  std::vector<int> compared;
  for (int i = 0; i < count; ++i) compared.push_back(int(std::int64_t(i) * vertices / count));
  return compared;
}

Cloud posed_cloud(const Surface& surface, std::span<const int> vertices, const Palette& palette) {
  Cloud cloud{Eigen::Matrix3Xd(3, Eigen::Index(vertices.size()))};
  for (size_t i = 0; i < vertices.size(); ++i) {
    const int v = vertices[i];
    cloud.points.col(Eigen::Index(i)) = transform(blend(surface.influences[v], palette), surface.position[v]);
  }
  const Vec3 centroid = cloud.points.rowwise().mean();
  cloud.points.colwise() -= centroid;
  cloud.square = cloud.points.squaredNorm();
  return cloud;
}

// The RMS distance that is left after the best rotation of `a` onto `b` (Horn 1987, section 4): the largest
// eigenvalue of a 4 x 4 matrix of the correlations is all that the residual needs.
double distance(const Cloud& a, const Cloud& b) {
  const Mat3 S = a.points * b.points.transpose();
  Eigen::Matrix4d N;
  N << S.trace(), S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0),                   //
      S(1, 2) - S(2, 1), S(0, 0) - S(1, 1) - S(2, 2), S(0, 1) + S(1, 0), S(2, 0) + S(0, 2),  //
      S(2, 0) - S(0, 2), S(0, 1) + S(1, 0), S(1, 1) - S(0, 0) - S(2, 2), S(1, 2) + S(2, 1),  //
      S(0, 1) - S(1, 0), S(2, 0) + S(0, 2), S(1, 2) + S(2, 1), S(2, 2) - S(0, 0) - S(1, 1);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(N, Eigen::EigenvaluesOnly);
  const double square = a.square + b.square - 2 * eigen.eigenvalues()[3];
  return std::sqrt(std::max(0.0, square) / double(a.points.cols()));
}

// Chooses frames by farthest point: Gonzalez' 2-approximation of the best cover.
class FrameChoice {
 public:
  FrameChoice(const Character& character, std::vector<ClipFrame> frames)
      : character_(character),
        frames_(std::move(frames)),
        vertices_(compared_vertices(character.surface)),
        same_(kSamePose * diagonal(character.surface.position)),
        clouds_(frames_.size()),
        nearest_(frames_.size(), std::numeric_limits<double>::infinity()) {
    parallel_for(int(frames_.size()), [&](int k) {
      clouds_[k] = cloud(sample(character.skeleton, *frames_[k].clip, frames_[k].time));
    });
  }

  /// Lets no frame be chosen, or left over, that shows `palette` up to a rigid motion.
  void know(const Palette& palette) { know(cloud(palette)); }

  /// The frame farthest from all that is known, which it then is too; none where no frame differs.
  const ClipFrame* choose() {
    const auto farthest = std::max_element(nearest_.begin(), nearest_.end());
    if (farthest == nearest_.end() || !(*farthest > same_)) return nullptr;
    const size_t k = size_t(farthest - nearest_.begin());
    know(clouds_[k]);
    return &frames_[k];
  }

  /// Up to `count` frames, evenly over all that differ from everything known.
  std::vector<ClipFrame> rest(int count) const {
    std::vector<ClipFrame> unknown;
    for (size_t k = 0; k < frames_.size(); ++k) {
      if (nearest_[k] > same_) unknown.push_back(frames_[k]);
    }
    const int left = int(unknown.size());
    count = std::min(count, left);
    std::vector<ClipFrame> spread;
    for (int i = 0; i < count; ++i)
      spread.push_back(unknown[size_t((2 * i + 1) * std::int64_t(left) / (2 * count))]);
    return spread;
  }

 private:
  Cloud cloud(const Palette& palette) const { return posed_cloud(character_.surface, vertices_, palette); }

  void know(const Cloud& known) {
    parallel_for(int(frames_.size()),
                 [&](int k) { nearest_[k] = std::min(nearest_[k], distance(known, clouds_[k])); });
  }

  const Character& character_;
  std::vector<ClipFrame> frames_;
  std::vector<int> vertices_;
  double same_;  // metres
  std::vector<Cloud> clouds_;
  std::vector<double> nearest_;  // metres from each frame to the nearest known pose
};

// How far a node turns about its rest, as rotation vectors in its own frame, radians.
struct Limits {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  bool still() const { return low == high && low.isZero(0); }
};

// The nodes that range-of-motion poses turn: joints with a joint above them. Turning a root moves all alike.
std::vector<bool> turning_nodes(const Skeleton& skeleton) {
  std::vector<bool> joint(skeleton.nodes.size(), false), below(skeleton.nodes.size(), false);
  for (const Joint& j : skeleton.joints) joint[j.node] = true;
  std::vector<bool> turning(skeleton.nodes.size(), false);
  for (const int n : parents_first(skeleton)) {
    const int parent = skeleton.nodes[n].parent;
    below[n] = parent >= 0 && (joint[parent] || below[parent]);
    turning[n] = joint[n] && below[n];
  }
  return turning;
}

// The nodes of joints that vertices follow with a weight that shows.
std::vector<bool> followed_nodes(const Character& character) {
  VecX mass = VecX::Zero(Eigen::Index(character.skeleton.nodes.size()));
  for (const Influences& influences : character.surface.influences) {
    for (const auto& [joint, weight] : influences) mass[character.skeleton.joints[joint].node] += weight;
  }
  std::vector<bool> followed;
  for (const double m : mass) followed.push_back(m > 1e-4 * double(character.surface.position.size()));
  return followed;
}

// The limits of each node that the frames show; still ones where no frame turns a node by more than 2
// degrees.
std::vector<Limits> seen_limits(const Skeleton& skeleton, std::span<const ClipFrame> frames) {
  constexpr double kStill = 2 * std::numbers::pi / 180, kWidening = 0.1;
  const size_t nodes = skeleton.nodes.size();
  std::vector<std::vector<Vec3>> turns(frames.size(), std::vector<Vec3>(nodes));
  parallel_for(int(frames.size()), [&](int k) {
    const auto transforms = sample_transforms(skeleton, *frames[k].clip, frames[k].time);
    for (size_t n = 0; n < nodes; ++n) {
      Quat back = normalised(skeleton.nodes[n].rest.rotation);
      back.head<3>() *= -1;
      turns[k][n] = rotation_vector(multiply(back, normalised(transforms[n].rotation)));
    }
  });
  std::vector<Limits> limits(nodes);
  for (size_t n = 0; n < nodes; ++n) {
    double largest = 0;
    Limits seen{Vec3::Constant(1e9), Vec3::Constant(-1e9)};
    for (const auto& turn : turns) {
      largest = std::max(largest, turn[n].norm());
      seen.low = seen.low.cwiseMin(turn[n]), seen.high = seen.high.cwiseMax(turn[n]);
    }
    if (largest <= kStill) continue;
    const Vec3 margin = kWidening * (seen.high - seen.low);
    limits[n] = {seen.low - margin, seen.high + margin};
  }
  return limits;
}

// Limits per node. Where clips turn joints they alone say how far: a joint that no clip turns stays still.
std::vector<Limits> joint_limits(const Character& character, std::span<const ClipFrame> frames) {
  constexpr double kUnknown = 35 * std::numbers::pi / 180;
  const std::vector<bool> turning = turning_nodes(character.skeleton), followed = followed_nodes(character);
  std::vector<Limits> limits = seen_limits(character.skeleton, frames);
  bool seen = false;
  for (size_t n = 0; n < limits.size(); ++n) {
    if (!turning[n]) limits[n] = {};
    seen |= !limits[n].still();
  }
  for (size_t n = 0; !seen && n < limits.size(); ++n) {
    if (turning[n] && followed[n]) limits[n] = {Vec3::Constant(-kUnknown), Vec3::Constant(kUnknown)};
  }
  return limits;
}

// `count` poses in which every joint is turned on its own, from raw engine output: the distributions of the
// standard library differ between libraries.
std::vector<Pose> motion_poses(const Character& character, std::span<const Limits> limits, int count,
                               std::uint32_t seed, const std::string& source) {
  const Skeleton& skeleton = character.skeleton;
  if (std::all_of(limits.begin(), limits.end(), [](const Limits& l) { return l.still(); })) return {};
  std::mt19937 random(seed);
  const std::vector<Affine> rest = rest_locals(skeleton);
  std::vector<Pose> poses;
  for (int p = 1; p <= count; ++p) {
    std::vector<Affine> locals = rest;
    for (size_t n = 0; n < limits.size(); ++n) {
      if (limits[n].still()) continue;
      Vec3 turned;
      for (int i = 0; i < 3; ++i) {
        const double share = static_cast<double>(random()) / 4294967296.0;
        turned[i] = limits[n].low[i] + share * (limits[n].high[i] - limits[n].low[i]);
      }
      const Node& node = skeleton.nodes[n];
      Transform transform = node.rest;
      transform.rotation = multiply(normalised(node.rest.rotation), turn(turned));
      locals[n] = node.matrix ? compose(*node.matrix, affine({.rotation = turn(turned)})) : affine(transform);
    }
    poses.push_back({source + " " + std::to_string(p), palette(skeleton, globals(skeleton, locals)),
                     sample_morph_weights(character.morphs, {}, 0)});
  }
  return poses;
}

// Every key of the clips called `name`.
std::vector<Pose> key_poses(const Character& character, const std::string& name) {
  std::vector<Pose> poses;
  std::string known;
  for (const Clip& clip : character.clips) {
    known += (known.empty() ? "" : ", ") + clip.name;
    if (clip.name != name) continue;
    for (const double time : key_times(clip)) poses.push_back(pose_at(character, {&clip, time}));
  }
  if (poses.empty()) {
    throw Error{Fault::Usage, character.name + ": clip '" + name +
                                  "': is not there or moves nothing: name one of " +
                                  (known.empty() ? "the file's clips; it has none" : known)};
  }
  return poses;
}

// Each of the `most` targets with the largest RMS offsets by itself, in the bind pose.
std::vector<Pose> morph_poses(const Character& character, int most) {
  const size_t count = character.morphs.size();
  std::vector<double> square(count);
  for (const MorphOffsets& offsets : character.surface.morphs) {
    for (const auto& [morph, delta] : offsets) square[morph] += delta.squaredNorm();
  }
  std::vector<size_t> chosen;
  for (size_t m = 0; m < count; ++m) {
    if (square[m] > 0) chosen.push_back(m);
  }
  std::stable_sort(chosen.begin(), chosen.end(), [&](size_t a, size_t b) { return square[a] > square[b]; });
  chosen.resize(std::min(chosen.size(), size_t(most)));
  std::sort(chosen.begin(), chosen.end());
  std::vector<Pose> poses;
  for (const size_t m : chosen) {
    Pose& pose = poses.emplace_back(Pose{"morph " + character.morphs[m].name,
                                         Palette(character.skeleton.joints.size(), identity()),
                                         std::vector<double>(count)});
    pose.morph_weights[m] = 1;
  }
  return poses;
}

}  // namespace

PoseSet choose_poses(const Character& character, const PoseOptions& options) {
  if (!(options.frames_per_second > 0)) throw Error{Fault::Usage, "frames per second: must be above 0"};
  const std::vector<ClipFrame> frames = clip_frames(character.clips, options.frames_per_second);

  PoseSet set;
  set.examples.push_back({"bind", Palette(character.skeleton.joints.size(), identity())});
  for (const std::string& name : options.pose_clips) {
    for (Pose& pose : key_poses(character, name)) set.examples.push_back(std::move(pose));
  }

  FrameChoice choice(character, frames);
  for (const Pose& pose : set.examples) choice.know(pose.palette);
  for (int i = 0; i < options.from_clips; ++i) {
    const ClipFrame* frame = choice.choose();
    if (!frame) break;
    set.examples.push_back(pose_at(character, *frame));
  }
  for (const ClipFrame& frame : choice.rest(options.unseen_clip_frames)) {
    set.unseen_clip.push_back(pose_at(character, frame));
  }

  const std::vector<Limits> limits = joint_limits(character, frames);
  for (Pose& pose :
       motion_poses(character, limits, options.range_of_motion, options.seed, "range of motion")) {
    set.examples.push_back(std::move(pose));
  }
  // Far from `seed` and from the seeds anybody would try next to it.
  set.unseen_motion = motion_poses(character, limits, options.unseen_range_of_motion,
                                   options.seed ^ 0x9e3779b9u, "unseen range of motion");
  set.morphs = morph_poses(character, options.morphs);
  return set;
}

}  // namespace skinlod
