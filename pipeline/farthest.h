// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "pipeline/closest.h"

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
  struct Corner {
    Vec3 share, there;  // barycentric: in the piece's face, and a point near it in the other's
  };
  std::vector<Piece> pieces;
  std::vector<Corner> corners;

  std::span<const Corner> ring(size_t piece) const {
    const int begin = piece == 0 ? 0 : pieces[piece - 1].end;
    return std::span(corners).subspan(size_t(begin), size_t(pieces[piece].end - begin));
  }
};

/// All of `from`, a piece for each face, to begin with.
Cover whole(const PosedSurface& from, const PosedSurface& to);

/// The same in pieces of which no point is farther from the near face than `within`, metres, by more than
/// the share `slack`; where the surfaces are farther apart, by more than that share than they are. A
/// `within` far below their distance makes very many pieces.
Cover finer(const PosedSurface& from, const PosedSurface& to, double within, double slack,
            const Cover& start);

/// The squared distance, m^2, that no point of `from` exceeds in its distance to `to`: the one-sided
/// Hausdorff distance from above. `known` is a squared distance of which it does not matter whether it is
/// exceeded by the share `slack` of its root, that of a sample for one: the result lies within that share
/// above the truth or above `known`, whichever is more, but for 1e-5 of the size.
double squared_bound(const PosedSurface& from, const PosedSurface& to, double known, double slack,
                     const Cover& cover);

}  // namespace skinlod
