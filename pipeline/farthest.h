// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pipeline/closest.h"
#include "pipeline/large_pages.h"

namespace skinlod {

/// A surface in convex pieces of its faces, each with a face of another surface that is near all of it. What
/// is near in one pose is near in others: a cover made in one makes the search in all a matter of looking it
/// over.
struct Cover {
  struct Piece {
    int face;
    int near;  // the face of the other surface
    int end;   // its corners end there; they begin where those of the piece before end
  };
  // Barycentric, to 1e-7, which is nothing here: what a cover takes to look over is its size in memory. The
  // first is what the others leave of 1.
  struct Share {
    Share(const Vec3& share) : second(float(share[1])), third(float(share[2])) {}
    operator Vec3() const { return {1.0 - second - third, double(second), double(third)}; }
    float second, third;
  };
  struct Corner {
    Share share, there;  // in the piece's face, and a point near it in the other's
  };
  LargeVector<Piece> pieces;
  LargeVector<Corner> corners;

  std::span<const Corner> ring(size_t piece) const {
    const int begin = piece == 0 ? 0 : pieces[piece - 1].end;
    return std::span(corners).subspan(size_t(begin), size_t(pieces[piece].end - begin));
  }
};

/// All of `from` in pieces that are somewhat nearer to their faces of `to` than the farthest point of `from`
/// is to `to`; or than the root of `known`, m^2, where that is more. A `known` far below the distance between
/// the surfaces makes no more pieces than their distance everywhere asks for, within the share `slack`.
Cover cover(const PosedSurface& from, const PosedSurface& to, double known, double slack);

/// A surface of triangles in four poses side by side, in floats: small, and made in no time, enough to see
/// where it may be far from another.
struct Sketch {
  template <class T>
  using PerPose = std::array<T, 4>;

  /// `tree` must outlive this; `points` has a place for each of its surface's vertices. Two that are compared
  /// have the same centres.
  Sketch(const FaceTree& tree, const PerPose<std::vector<Vec3>>& points, const PerPose<Vec3>& centres);

  std::span<const std::array<int, 3>> faces;      // vertices of each
  std::vector<std::array<FourFloats, 3>> points;  // per vertex x, y and z in each pose, about its centre
  PerPose<double> reach{};                        // metres: none is farther from the centre
};

/// Per pose, the pieces of `cover` that may have a point farther from `to` than the root of `known`, m^2:
/// those first that may be the farthest. None of the others has one.
Sketch::PerPose<std::vector<int>> doubts(const Sketch& from, const Sketch& to,
                                         const Sketch::PerPose<double>& known, const Cover& cover);

/// The squared distance, m^2, that no point of `from` exceeds in its distance to `to`: the one-sided
/// Hausdorff distance from above. `known` is a squared distance of which it does not matter whether it is
/// exceeded by the share `slack` of its root, that of a sample for one: the result lies within that share
/// above the truth or above `known`, whichever is more, but for 1e-5 of the size. `doubts` are those of
/// `cover`.
double squared_bound(const PosedSurface& from, const PosedSurface& to, double known, double slack,
                     const Cover& cover, std::span<const int> doubts);

}  // namespace skinlod
