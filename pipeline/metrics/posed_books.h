// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/history.h"
#include "pipeline/pose.h"
#include "pipeline/quadric.h"

/// What the metrics that look at poses know of every vertex.
namespace skinlod {

/// Where each vertex of a mesh that is being collapsed stands in each pose.
class PosedPoints {
 public:
  PosedPoints(const Mesh& mesh, std::span<const Influences> influences, std::span<const Pose> poses);

  size_t pose_count() const { return palettes_.size(); }
  std::span<const Palette> palettes() const { return palettes_; }
  const Vec3& at(int vertex, size_t pose) const { return posed_[vertex * pose_count() + pose]; }

  /// From here on `vertex` has this rest position and these influences.
  void move(int vertex, const Vec3& position, const Influences& influences);
  void move(const History& steps);

  /// True where carrying the collapse out turns a face over in some pose.
  bool turns_a_face(const Mesh& mesh, Edge e, const Placement& to) const;

 private:
  std::vector<Palette> palettes_;  // per pose
  std::vector<Vec3> posed_;        // [vertex * poses + pose]
};

/// One quadric per vertex and pose: the surface quadrics of the mesh as it stands in that pose.
class PosedQuadrics {
 public:
  PosedQuadrics(const Mesh& mesh, const PosedPoints& points);

  /// One per pose.
  std::span<const Quadric> of(int vertex) const { return {&quadric_[vertex * poses_], poses_}; }

  /// The sum over all poses and both ends of what they say of the kept end, of the removed one, and of the
  /// best of all points that lie between them by the same share in every pose; never negative.
  struct Along {
    double kept, removed, least;
  };
  Along along(Edge e, const PosedPoints& points) const;

  /// From here on the kept end has the sum.
  void merge(Edge e);

  /// Of all planes in all poses: over it the squared distances that all vertices say sum up to their mean.
  double weight() const { return weight_; }

 private:
  size_t poses_;
  double weight_ = 0;
  std::vector<Quadric> quadric_;  // [vertex * poses + pose]
};

}  // namespace skinlod
