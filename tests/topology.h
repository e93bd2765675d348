// SPDX-License-Identifier: MIT
#pragma once

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

/// Random rotations of up to `angle` radians and offsets of up to `shift`, the same for the same seed.
Palette random_palette(int joints, unsigned seed, double angle, double shift = 0);

}  // namespace skinlod
