// SPDX-License-Identifier: MIT
#include "pipeline/evaluate.h"

// A triangle is at no distance from itself: this needs the ray tracer and the task scheduler the package
// names.
int main() {
  using namespace skinlod;
  Surface surface;
  surface.position = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()};
  surface.influences.assign(3, {{0, 1.0}});
  surface.wedges = {{0, 0}, {1, 0}, {2, 0}};
  surface.attributes = Rows::Zero(3, surface.layout.columns());
  surface.add_face(std::vector{0, 1, 2});
  const std::vector<Pose> poses = {{"bind", {identity()}}};
  const skinlod::Surface* level = &surface;
  return posed_error(deviations(surface, {&level, 1}, poses).front()).max < 1e-6 ? 0 : 1;
}
