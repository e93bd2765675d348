// SPDX-License-Identifier: MIT
#include "pipeline/farthest.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace skinlod {
namespace {

// Below this share of the surfaces' size a distance is nothing to search for: half a step of 16-bit
// positions.
constexpr double kNothing = 1e-5;

// Pieces that reach across a line by less than this share of the size are not cut: it must be small against
// any distance that is searched for, or there is no end to the pieces.
constexpr double kOnLine = 1e-8;

// A corner of a piece: where it is in the face, and where that is in the pose.
struct Corner {
  Vec3 share, x;
};
using Ring = std::vector<Corner>;

struct Suspect {
  int face;
  Ring ring;
  int near;
  double upper = std::numeric_limits<double>::infinity();  // m^2: none of its points is farther
  bool operator<(const Suspect& o) const { return upper < o.upper; }
};

// The part of the ring where `side` is not positive, and the part where it is not negative.
struct Halves {
  Ring inside, outside;
};
template <class Side>
Halves cut(const Ring& ring, const Side& side) {
  Halves halves;
  for (size_t i = 0; i < ring.size(); ++i) {
    const Corner &a = ring[i], &b = ring[(i + 1) % ring.size()];
    const double at_a = side(a.x), at_b = side(b.x);
    if (at_a <= 0) halves.inside.push_back(a);
    if (at_a >= 0) halves.outside.push_back(a);
    if ((at_a < 0 && at_b > 0) || (at_a > 0 && at_b < 0)) {
      const double t = at_a / (at_a - at_b);
      const Corner between{a.share + t * (b.share - a.share), a.x + t * (b.x - a.x)};
      halves.inside.push_back(between), halves.outside.push_back(between);
    }
  }
  return halves;
}

// Branch and bound. The distance to one face of `to` is a convex function, so over a polygon it is the
// largest at a corner, and with the right face that is a bound which is hardly too large. A piece that no
// face bounds well enough is cut along the outline of the face nearest to its middle: what lies over the face
// is done with, and the rest looks for faces of its own. So a large triangle over many small ones takes about
// one cut for each of them, however near it is.
class FarthestPoint {
 public:
  FarthestPoint(const PosedSurface& from, const PosedSurface& to, double known, double slack, Cover* found)
      : from_(from),
        to_(to),
        lower_(known),
        slack_(slack),
        nothing_(kNothing * std::max(from.size(), to.size())),
        on_line_(kOnLine / kNothing * nothing_),
        found_(found) {}

  void look_over(const Cover& cover) {
    for (const Piece& piece : cover) {
      const double upper = bound_of(piece);
      if (upper <= allowed()) {
        passed_ = std::max(passed_, upper);
        if (found_) found_->push_back(piece);
      } else {
        waiting_.push(posed(piece));
      }
    }
  }

  double squared_bound() {
    while (!waiting_.empty() && waiting_.top().upper > allowed()) {
      Suspect suspect = waiting_.top();
      waiting_.pop();
      refine(std::move(suspect));
    }
    const double waiting = waiting_.empty() ? 0 : waiting_.top().upper;
    for (; !waiting_.empty(); waiting_.pop()) pass(waiting_.top());
    return std::max({lower_, passed_, waiting});
  }

 private:
  double allowed() const { return std::max((1 + slack_) * (1 + slack_) * lower_, nothing_ * nothing_); }

  ClosestPoint nearest(const Vec3& x, int guess) {
    const ClosestPoint there = to_.closest(x, guess);
    lower_ = std::max(lower_, there.squared);
    return there;
  }

  double bound_of(const Piece& piece) const {
    double farthest = 0;
    for (const Vec3& share : piece.ring)
      farthest = std::max(farthest, to_.squared_distance(from_.at(piece.face, share), piece.near));
    return farthest;
  }

  Suspect posed(const Piece& piece) const {
    Suspect suspect{piece.face, {}, piece.near};
    for (const Vec3& share : piece.ring) suspect.ring.push_back({share, from_.at(piece.face, share)});
    bound(suspect, piece.near);
    return suspect;
  }

  void bound(Suspect& suspect, int face) const {
    double farthest = 0;
    for (const Corner& c : suspect.ring) farthest = std::max(farthest, to_.squared_distance(c.x, face));
    if (farthest < suspect.upper) suspect.upper = farthest, suspect.near = face;
  }

  void pass(const Suspect& suspect) {
    passed_ = std::max(passed_, suspect.upper);
    if (!found_) return;
    Piece& piece = found_->emplace_back(Piece{suspect.face, {}, suspect.near});
    for (const Corner& c : suspect.ring) piece.ring.push_back(c.share);
  }

  void keep(Suspect suspect) {
    if (suspect.upper > allowed()) {
      waiting_.push(std::move(suspect));
    } else {
      pass(suspect);
    }
  }

  void refine(Suspect suspect) {
    Vec3 middle = Vec3::Zero();
    for (const Corner& c : suspect.ring) middle += c.x;
    middle /= double(suspect.ring.size());
    const ClosestPoint there = nearest(middle, suspect.near);
    bound(suspect, there.face);
    double radius = 0;
    for (const Corner& c : suspect.ring) radius = std::max(radius, (c.x - middle).norm());
    // Good for this pose alone: in another the piece would have to ask for its middle again.
    const double reach = std::sqrt(there.squared) + radius;
    if (!found_) suspect.upper = std::min(suspect.upper, reach * reach);
    if (suspect.upper <= allowed() || radius <= nothing_) {
      pass(suspect);
    } else {
      cut_along(std::move(suspect), there.face, middle);
    }
  }

  // A little beyond the face's edges, so that a piece which lies over the face is one with rounding and all.
  void cut_along(Suspect suspect, int face, const Vec3& middle) {
    const double margin = std::sqrt(allowed()) / 2;
    const auto& corner = to_.triangle(face);
    const Vec3 n = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    Ring& rest = suspect.ring;
    bool is_cut = false;
    for (int k = 0; k < 3 && n.squaredNorm() > 0; ++k) {
      const Vec3& a = corner[k];
      const Vec3 across = (corner[(k + 1) % 3] - a).cross(n).normalized();
      const auto side = [&](const Vec3& x) { return across.dot(x - a) - margin; };
      const auto reaches = [&](double sign) {
        return std::any_of(rest.begin(), rest.end(),
                           [&](const Corner& c) { return sign * side(c.x) > on_line_; });
      };
      if (!reaches(-1)) break;  // it lies beside the face
      if (!reaches(1)) continue;
      Halves halves = cut(rest, side);
      add(suspect, std::move(halves.outside), face);
      rest = std::move(halves.inside);
      is_cut = true;
    }
    if (is_cut) {
      add(suspect, std::move(rest), face);
    } else {
      halve(suspect, middle);
    }
  }

  void add(const Suspect& whole, Ring ring, int face) {
    Suspect part{whole.face, std::move(ring), whole.near, whole.upper};
    bound(part, face);
    keep(std::move(part));
  }

  // Through the middle, across the way to the corner farthest from it.
  void halve(const Suspect& suspect, const Vec3& middle) {
    const auto nearer = [&](const Corner& a, const Corner& b) {
      return (a.x - middle).squaredNorm() < (b.x - middle).squaredNorm();
    };
    const Vec3 along = std::max_element(suspect.ring.begin(), suspect.ring.end(), nearer)->x - middle;
    Halves halves = cut(suspect.ring, [&](const Vec3& x) { return along.dot(x - middle); });
    add(suspect, std::move(halves.inside), suspect.near);
    add(suspect, std::move(halves.outside), suspect.near);
  }

  const PosedSurface &from_, &to_;
  double lower_;  // m^2: so far there is a point, or it does not matter
  double slack_;
  double nothing_, on_line_;  // metres
  double passed_ = 0;         // m^2: the largest bound of what is not looked into
  std::priority_queue<Suspect> waiting_;
  Cover* found_;  // takes all that has passed; or null
};

}  // namespace

Cover whole(const PosedSurface& from, const PosedSurface& to, double& farthest) {
  const std::vector<Vec3> all = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  std::vector<int> near(from.surface().position.size(), -1);
  Cover cover;
  int guess = 0;
  for (int f = 0; f < from.surface().face_count(); ++f) {
    for (const int v : from.vertices(f)) {
      if (near[v] >= 0) continue;
      const ClosestPoint there = to.closest(from.point(v), guess);
      near[v] = guess = there.face;
      farthest = std::max(farthest, there.squared);
    }
    cover.push_back({f, all, near[from.vertices(f)[0]]});
  }
  return cover;
}

double squared_bound(const PosedSurface& from, const PosedSurface& to, double known, double slack,
                     const Cover& start, Cover* refined) {
  Cover found;
  FarthestPoint search(from, to, known, slack, refined ? &found : nullptr);
  search.look_over(start);
  const double bound = search.squared_bound();
  if (refined) *refined = std::move(found);
  return bound;
}

}  // namespace skinlod
