// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

#include "pipeline/character.h"
#include "pipeline/history.h"
#include "pipeline/pose.h"

/// What a surface is, told apart from how the code under test sees it.
namespace skinlod {

/// V - E + F over the vertices that faces use: 2 for a sphere, 0 for a torus, 1 for a disc.
int euler_characteristic(const Surface& surface);

/// The number of edges with one face.
int border_edges(const Surface& surface);

/// The number of connected chains of border edges.
int border_loops(const Surface& surface);

/// By the divergence theorem; triangles only. Positive where a closed surface faces outwards.
double volume(const Surface& surface);
double area(const Surface& surface);

/// Plays the history on the source and counts the faces that a collapse turns by a right angle or more in one
/// of the poses; `seen` is the number of faces compared. Needs no metric: this is what they promise.
struct TurnedFaces {
  int turned = 0, seen = 0;
};
TurnedFaces turned_faces(const Surface& source, const History& history, std::span<const Pose> poses);

/// A level as the collapse left it, before anything was fitted.
struct Traced {
  Surface surface;
  std::vector<int> face;  // of the source, which each face of the surface was
};
Traced traced(const Surface& source, const History& history, std::size_t steps);

/// How far from where it should be a vertex of a surface may lie in a pose, metres.
using Reach = std::function<double(int vertex, const Palette& palette)>;

/// Face f of `after` was face `face[f]` of `before`, or f where there are none: those that look a right angle
/// or more away from it in one of the poses, and those that are turned over in one of the uv sets, or
/// flattened. What has no area before has no side to be turned to. With corners that lie as much as `reach`
/// from where they should, a face counts where it is turned wherever within reach they should be.
TurnedFaces turned_faces(const Surface& before, const Surface& after, std::span<const Pose> poses,
                         std::span<const int> face = {}, const Reach& reach = {});
TurnedFaces turned_uvs(const Surface& before, const Surface& after, std::span<const int> face = {},
                       double reach = 0);

/// Wedges whose position, influences or morph offsets differ in a bit from those of the first wedge that
/// stands for the same point. `point` says for which each does.
int cracks(const Surface& surface, std::span<const int> point);

/// Random rotations of up to `angle` radians and offsets of up to `shift`, the same for the same seed.
Palette random_palette(int joints, unsigned seed, double angle, double shift = 0);

}  // namespace skinlod
