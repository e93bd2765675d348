// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/closest.h"

namespace skinlod {

/// A surface in convex pieces of its faces, each with a face of another surface that is near all of it. What
/// is near in one pose is near in others: a cover made in one makes the search in all a matter of looking it
/// over.
class Cover {
 public:
  /// A corner of a piece: where it is in the piece's face, and a point near it in the other's, both
  /// barycentric.
  struct Corner {
    Vec3 share, there;
  };
  /// Four corners side by side, to 1e-7, which is nothing here: what a cover takes to look over is its size
  /// in memory. The first share is what the others leave of 1.
  struct FourShares {
    FourFloats second, third;
  };
  struct FourCorners {
    FourShares share, there;
  };
  struct Piece {
    int face;
    int near;  // the face of the other surface
    int end;   // its fours of corners end there; they begin where those of the piece before end
  };

  void add(int face, int near, std::span<const Corner> ring);

  std::span<const Piece> pieces() const { return pieces_; }

  /// The corners of a piece, as they are looked over: the last fills up its last four.
  std::span<const FourCorners> fours(size_t piece) const {
    const int begin = piece == 0 ? 0 : pieces_[piece - 1].end;
    return std::span(corners_).subspan(size_t(begin), size_t(pieces_[piece].end - begin));
  }

  /// The corners of a piece, each once.
  std::vector<Corner> ring(size_t piece) const;

 private:
  std::vector<Piece> pieces_;
  std::vector<FourCorners> corners_;
};

/// All of `from` in pieces that are somewhat nearer to their faces of `to` than the farthest point of `from`
/// is to `to`; or than the root of `known`, m^2, where that is more. A `known` far below the distance between
/// the surfaces makes no more pieces than their distance everywhere asks for, within the share `slack`.
Cover cover(const PosedSurface& from, const PosedSurface& to, double known, double slack);

/// A surface of triangles in one pose, in floats: small, and made in no time, enough to see where it may be
/// far from another about the same centre.
struct Sketch {
  /// `tree` must outlive this; `points` has a place for each of its surface's vertices.
  Sketch(const FaceTree& tree, std::span<const Vec3> points, const Vec3& centre);

  std::span<const std::array<int, 3>> faces;  // vertices of each
  std::vector<FourFloats> points;             // per vertex three of the four, about the centre
  double reach = 0;                           // metres: none is farther from the centre
};

/// The pieces of `cover` that may have a point farther from `to` than the root of `known`, m^2: those first
/// that may be the farthest. None of the others has one.
std::vector<int> doubts(const Sketch& from, const Sketch& to, double known, const Cover& cover);

/// The squared distance, m^2, that no point of `from` exceeds in its distance to `to`: the one-sided
/// Hausdorff distance from above. `known` is a squared distance of which it does not matter whether it is
/// exceeded by the share `slack` of its root, that of a sample for one: the result lies within that share
/// above the truth or above `known`, whichever is more, but for 1e-5 of the size. `doubts` are those of
/// `cover`.
double squared_bound(const PosedSurface& from, const PosedSurface& to, double known, double slack,
                     const Cover& cover, std::span<const int> doubts);

}  // namespace skinlod
