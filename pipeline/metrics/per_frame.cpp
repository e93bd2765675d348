// SPDX-License-Identifier: MIT
#include "pipeline/metrics/per_frame.h"

#include <algorithm>
#include <functional>

#include "pipeline/collapse.h"
#include "pipeline/error.h"
#include "pipeline/metrics/rest_pose.h"
#include "pipeline/repair.h"

namespace skinlod {

std::vector<Surface> simplify_frame(const Surface& source, std::span<const Vec3> posed,
                                    std::span<const int> triangles) {
  if (!std::is_sorted(triangles.begin(), triangles.end(), std::greater<>())) {
    throw Error(Fault::Usage, "triangles: list the counts from fine to coarse");
  }
  Surface frame = triangulated(source);  // as every metric sees it, whatever the pose
  frame.position.assign(posed.begin(), posed.end());
  frame = without_attributes(frame);
  frame.influences.assign(frame.position.size(), {{0, 1.0}});

  Mesh mesh(frame);
  RestPoseMetric metric(mesh, frame.influences);
  std::vector<Surface> levels;
  for (const int count : triangles) {
    collapse(mesh, metric, count);
    levels.push_back(mesh.surface(metric.influences()));
  }
  return levels;
}

}  // namespace skinlod
