// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>

#include <algorithm>
#include <numbers>
#include <random>

#include "pipeline/bounds.h"
#include "tests/packed_tube.h"
#include "tests/random.h"

/// A packed level posed by the loader, and its bounds: for tests of both.
namespace skinlod {

/// One level of a file, ready to be posed many times.
class PosableLevel {
 public:
  PosableLevel(const slod_file& file, std::uint32_t level)
      : file_(file),
        level_(level),
        rest_(unpacked(file, level, SLOD_POSITION)),
        joints_(decoded<std::uint8_t>(file, level, SLOD_JOINT_INDEX)),
        weights_(decoded<std::uint8_t>(file, level, SLOD_WEIGHT)),
        palette_(12 * size_t(slod_count(&file, SLOD_JOINTS))) {
    if (slod_find(&file, level, SLOD_MORPH_OFFSET, 0) == SLOD_NONE) return;
    ranges_ = decoded<std::uint32_t>(file, level, SLOD_MORPH_RANGE);
    offsets_ = decoded<slod_morph_offset>(file, level, SLOD_MORPH_OFFSET);
  }

  /// The box around the vertices that the loader skins. `morphs`: a weight for each of the file's, or empty.
  Box box(std::span<const float> globals, std::span<const float> morphs = {}) {
    std::vector<float> x = rest_;
    if (!morphs.empty() && !offsets_.empty()) {
      const slod_chunk chunk = slod_get_chunk(&file_, slod_find(&file_, level_, SLOD_MORPH_OFFSET, 0));
      slod_add_morphs(&file_, &chunk, ranges_.data(), offsets_.data(), morphs.data(), x.data(), nullptr);
    }
    slod_palette(&file_, globals.data(), palette_.data());
    slod_skin(&file_, level_, joints_.data(), weights_.data(), palette_.data(), x.data(), nullptr);
    Box box;
    for (size_t v = 0; v < x.size() / 3; ++v) box.add(point(x, v), point(x, v));
    return box;
  }

  /// What slod_posed_bounds says of it.
  Box bounds(std::span<const float> globals) const {
    float low[3], high[3];
    slod_posed_bounds(&file_, level_, globals.data(), low, high);
    return {Vec3(low[0], low[1], low[2]), Vec3(high[0], high[1], high[2])};
  }

 private:
  const slod_file& file_;
  std::uint32_t level_;
  std::vector<float> rest_;
  std::vector<std::uint8_t> joints_, weights_;
  std::vector<std::uint32_t> ranges_{};
  std::vector<slod_morph_offset> offsets_{};
  std::vector<float> palette_;
};

/// The box with a hundredth of its size taken away.
inline Box shrunk(const Box& box) {
  const Vec3 edge = (box.max - box.min) / 200;
  return {box.min + edge, box.max - edge};
}

inline double volume(const Box& box) { return (box.max - box.min).prod(); }

inline std::vector<float> rest_globals(const slod_file& file) {
  std::vector<float> globals(12 * size_t(slod_count(&file, SLOD_NODES)));
  slod_rest_locals(&file, globals.data());
  slod_globals(&file, globals.data(), globals.data());
  return globals;
}

/// What an animation may do, and more: every node turned by up to half a turn about any axis and scaled by
/// 0.5 to 2 along each of its own, from where it is at rest.
inline std::vector<float> random_globals(const slod_file& file, std::mt19937& random) {
  std::vector<float> globals(12 * size_t(slod_count(&file, SLOD_NODES)));
  slod_rest_locals(&file, globals.data());
  for (size_t n = 0; n < globals.size() / 12; ++n) {
    Eigen::Map<Eigen::Matrix<float, 3, 4, Eigen::RowMajor>> local(globals.data() + 12 * n);
    const double angle = uniform(random, 0, std::numbers::pi);
    const Vec3 axis = (random_vector(random, 1) + Vec3(0, 0, 1e-9)).normalized();
    const Vec3 scale(uniform(random, 0.5, 2), uniform(random, 0.5, 2), uniform(random, 0.5, 2));
    const Mat3 turn = Eigen::AngleAxisd(angle, axis).toRotationMatrix() * scale.asDiagonal();
    local.leftCols<3>() = (local.leftCols<3>().cast<double>() * turn).cast<float>();
  }
  slod_globals(&file, globals.data(), globals.data());
  return globals;
}

/// The nodes of the file, whose order is that of `parents_first`, in a frame of a clip.
inline std::vector<float> clip_globals(const Skeleton& skeleton, const Clip& clip, double time) {
  const std::vector<Affine> posed = globals(skeleton, sample_locals(skeleton, clip, time));
  std::vector<float> rows;
  for (const int n : parents_first(skeleton)) {
    for (int i = 0; i < 12; ++i) rows.push_back(float(posed[size_t(n)](i / 4, i % 4)));
  }
  return rows;
}

/// How far the bounds hold: in the rest pose, and in `poses` random poses with random morph weights.
struct Held {
  int outside = 0;         // poses in which a vertex is not inside
  int outside_shrunk = 0;  // the same where the bounds are made smaller by a hundredth
};

inline Held hold(const slod_file& file, std::uint32_t level, int poses) {
  std::mt19937 random(11);
  PosableLevel posable(file, level);
  Held held;
  for (int i = 0; i <= poses; ++i) {
    const std::vector<float> nodes = i == 0 ? rest_globals(file) : random_globals(file, random);
    std::vector<float> morphs(slod_count(&file, SLOD_MORPHS), 0);
    for (size_t m = 0; m < morphs.size() && i > 0; ++m) morphs[m] = float(uniform(random, 0, 1));
    const Box box = posable.box(nodes, morphs), bounds = posable.bounds(nodes);
    held.outside += !bounds.contains(box);
    held.outside_shrunk += !shrunk(bounds).contains(box);
  }
  return held;
}

/// The volume of the bounds in parts of the tight box's, over all frames of all clips: geometric mean and
/// most.
struct Looseness {
  double mean = 0, most = 0;
  int frames = 0, outside = 0, outside_shrunk = 0, outside_clip_box = 0, outside_shrunk_clip_box = 0;
};

inline Looseness looseness(const slod_file& file, std::uint32_t level, const Character& character) {
  PosableLevel posable(file, level);
  float low[3], high[3];
  REQUIRE(slod_clip_bounds(&file, level, low, high) == 1);
  const Box clips{Vec3(low[0], low[1], low[2]), Vec3(high[0], high[1], high[2])};
  Looseness loose;
  for (const Clip& clip : character.clips) {
    for (int k = 0; k <= int(std::ceil(30 * clip.duration())); ++k) {
      const auto nodes = clip_globals(character.skeleton, clip, std::min(k / 30.0, clip.duration()));
      const Box box = posable.box(nodes), bounds = posable.bounds(nodes);
      const double ratio = volume(bounds) / volume(box);
      loose.mean += std::log(ratio), loose.most = std::max(loose.most, ratio);
      ++loose.frames;
      loose.outside += !bounds.contains(box), loose.outside_shrunk += !shrunk(bounds).contains(box);
      loose.outside_clip_box += !clips.contains(box);
      loose.outside_shrunk_clip_box += !shrunk(clips).contains(box);
    }
  }
  loose.mean = std::exp(loose.mean / loose.frames);
  return loose;
}

}  // namespace skinlod
