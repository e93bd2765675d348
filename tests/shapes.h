// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

#include "pipeline/character.h"
#include "pipeline/pose.h"

/// Meshes and characters made by formula, for tests: known area, volume, genus and motion.
namespace skinlod {

/// A closed box of the given size about the origin, each side a grid of n x n quads cut into triangles.
Surface grid_box(const Vec3& size, int n);

/// A triangulated cylinder wall of radius 1 along +y from 0 to `length`: `around` x `rings` quads, cut.
/// `closed`: with a fan at each end.
Surface tube(int around, int rings, double length, bool closed = false);

/// A sphere of radius 1 by `level` subdivisions of the octahedron: 8 * 4^level triangles.
Surface sphere(int level);

/// A closed torus, radii 2 and 1/2: genus 1.
Surface torus(int around, int through);

/// The unit square in the plane z = 0, n x n squares cut into triangles, with normals, tangents and a uv set
/// that follows the points. Vertex i * (n + 1) + j is at (i / n, j / n); each has one wedge of the same
/// number.
Surface sheet(int n);

/// A character: the closed tube of length `joints`, joint j at height j, smooth weights over the two nearest
/// joints, normals, one uv set with a seam along the tube, and clips "bend" and "twist" of one second that
/// turn every joint by 40 degrees about z and by 30 degrees about y.
Character bending_tube(int around, int rings, int joints);

/// The character with those faces alone whose middle is `inside`: as one file of several that make it up.
/// What it does not use is still there; `weld` drops it.
Character part_of(Character whole, const std::function<bool(const Vec3& middle)>& inside);

/// The square column of Landreneau and Schaefer's Table 1 and Figure 4: 1 x 8 x 1, four sides of `n` x
/// `rings` quads and two ends of n x n, cut into triangles. n = 32, rings = 432 give their 114,688 triangles
/// exactly. Five joints along +y, smooth weights, a clip "bend" and a clip "twist" of one second each.
Character square_column(int n = 32, int rings = 432);

/// Poses of `c` for a quick cook: three of its clips and one of its range of motion, and as many unseen.
PoseSet few_poses(const Character& c);

/// True where two surfaces are the same to the last bit.
bool same(const Surface& a, const Surface& b);

}  // namespace skinlod
