// SPDX-License-Identifier: MIT
#include "pipeline/baseline.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <limits>

#include "pipeline/error.h"
#include "pipeline/mesh.h"
#include "pipeline/parallel.h"

namespace skinlod {
namespace {

Metric metric_of(Baseline baseline) {
  switch (baseline) {
    case Baseline::Endpoint:
      return Metric::Endpoint;
    case Baseline::RestPose:
      return Metric::RestPose;
    case Baseline::PoseIndependent:
      return Metric::PoseIndependent;
    case Baseline::MeshoptSimplify:
      break;
  }
  throw Error(Fault::Ours, "baseline: is no metric of ours");
}

// The surfaces of a baseline, one for each level that is not the source itself.
std::vector<Surface> baseline_surfaces(const Character& character, const PoseSet& poses,
                                       std::span<const Level* const> levels, Baseline baseline) {
  std::vector<Surface> surfaces;
  if (baseline == Baseline::MeshoptSimplify) {
    for (const Level* level : levels)
      surfaces.push_back(meshopt_level(character.surface, triangle_count(level->surface)));
    return surfaces;
  }
  ChainOptions options{
      .targets = {}, .metric = metric_of(baseline), .source_level = false, .measured = false};
  for (const Level* level : levels) {
    options.targets.push_back(
        {.triangles = triangle_count(level->surface), .max_influences = level->max_influences});
  }
  Chain chain = build_chain(character, poses, options);
  for (Level& level : chain.levels) surfaces.push_back(std::move(level.surface));
  return surfaces;
}

}  // namespace

MeshoptInput::MeshoptInput(const Surface& surface)
    : indices_(surface.corners.begin(), surface.corners.end()) {
  for (const Wedge& wedge : surface.wedges) {
    for (const double x : surface.position[wedge.vertex]) points_.push_back(float(x));
  }
}

// Its order of collapses does not depend on the limit to its error, so that to raise one step by step comes
// to the same as none.
std::vector<unsigned> MeshoptInput::simplified(size_t triangles) const {
  constexpr float kNoLimit = std::numeric_limits<float>::max();
  std::vector<unsigned> left(indices_.size());
  left.resize(meshopt_simplify(left.data(), indices_.data(), indices_.size(), points_.data(),
                               points_.size() / 3, 3 * sizeof(float), 3 * triangles, kNoLimit));
  return left;
}

Surface meshopt_level(const Surface& source, int triangles) {
  Surface level = triangulated(source);
  const MeshoptInput input(level);
  const auto vertex = [&](unsigned wedge) { return level.wedges[wedge].vertex; };
  // It may collapse a small closed piece to nothing, and with it all there is.
  level.corners.clear();
  level.face_begin = {0};
  for (size_t target = size_t(std::max(1, triangles)); level.corners.empty(); target *= 2) {
    const std::vector<unsigned> left = input.simplified(target);
    for (size_t i = 0; i < left.size(); i += 3) {
      const unsigned a = left[i], b = left[i + 1], c = left[i + 2];
      // Two wedges of one vertex may end up in one face, which then is a line.
      if (vertex(a) != vertex(b) && vertex(b) != vertex(c) && vertex(c) != vertex(a))
        level.add_face(std::array{int(a), int(b), int(c)});
    }
  }
  return Mesh(level).surface(level.influences);
}

std::vector<std::vector<BaselineLevel>> measure_baselines(const Character& character, const PoseSet& poses,
                                                          std::span<const Level> levels,
                                                          std::span<const Baseline> baselines) {
  std::vector<const Level*> made;
  for (const Level& level : levels) {
    if (level.steps > 0) made.push_back(&level);
  }
  std::vector<std::vector<Surface>> surfaces(baselines.size());
  parallel_for(int(baselines.size()),
               [&](int b) { surfaces[b] = baseline_surfaces(character, poses, made, baselines[b]); });

  const Surface source = triangulated(character.surface);
  std::vector<const Surface*> all;
  for (const auto& some : surfaces) {
    for (const Surface& surface : some) all.push_back(&surface);
  }
  const std::array<std::span<const Pose>, 2> sets = {poses.unseen_clip, poses.unseen_motion};
  const auto errors = posed_errors(source, all, sets);

  std::vector<std::vector<BaselineLevel>> measured(baselines.size());
  size_t next = 0;
  for (auto& of_levels : measured) {
    for (const Level& level : levels) {
      BaselineLevel& b = of_levels.emplace_back(BaselineLevel{.triangles = triangle_count(source)});
      if (level.steps == 0) continue;
      b.triangles = triangle_count(*all[next]);
      b.unseen_clip = errors[next][0], b.unseen_motion = errors[next][1];
      ++next;
    }
  }
  return measured;
}

}  // namespace skinlod
