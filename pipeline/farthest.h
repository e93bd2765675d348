// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/closest.h"

namespace skinlod {

/// A convex piece of a face, with a face of another surface that is near all of it.
struct Piece {
  int face;                // it is a piece of
  std::vector<Vec3> ring;  // its corners, barycentric in `face`
  int near;                // the face of the other surface
};

/// A surface in pieces. What is near in one pose is near in others: the cover found in one pose makes the
/// search in the next a matter of looking it over.
using Cover = std::vector<Piece>;

/// All of `from`, a piece for each face, for a search to begin with. `farthest` grows to the squared distance
/// of the vertex farthest from `to`, m^2.
Cover whole(const PosedSurface& from, const PosedSurface& to, double& farthest);

/// The squared distance, m^2, that no point of `from` exceeds in its distance to `to`: the one-sided
/// Hausdorff distance from above. `known` is a squared distance of which it does not matter whether it is
/// exceeded by the share `slack` of its root, that of a sample for one: the result lies within that share
/// above the truth or above `known`, whichever is more, but for 1e-5 of the size. `refined`, which may be
/// null, gets the pieces that the search ends with; it may be `start`.
double squared_bound(const PosedSurface& from, const PosedSurface& to, double known, double slack,
                     const Cover& start, Cover* refined = nullptr);

}  // namespace skinlod
