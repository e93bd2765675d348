// SPDX-License-Identifier: MIT
#include "pipeline/farthest.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace skinlod {
namespace {

// Below this share of the surfaces' size a distance is nothing to search for: half a step of 16-bit
// positions.
constexpr double kNothing = 1e-5;

// Pieces that reach across a line by less than this share of the size are not cut: it must be small against
// any distance that is searched for, or there is no end to the pieces.
constexpr double kOnLine = 1e-8;

// A cover is made in one pose so fine that in the others hardly a piece has to be cut: of the largest
// distance this share.
constexpr double kCoverWithin = 0.75;

// Distances between sketches may be off by so much of their reach: 12 roundings of 2^-24.
constexpr double kRounding = 1e-6;

// A corner of a piece: where it is in the face, and where that is in the pose.
struct Corner {
  Vec3 share, x;
};
using Ring = std::vector<Corner>;

// A piece whose corners are on the top of the stack once those of the suspects after it are gone.
struct Suspect {
  int face;
  size_t begin;  // its first corner on the stack
  int near;
  double upper = std::numeric_limits<double>::infinity();  // m^2: none of its points is farther
  int tried = -1;                                          // the last face that was asked for a bound
};

// Adds the part of the ring where `side` is not positive to `inside`, and that where it is not negative to
// `outside`.
void cut(const Ring& ring, std::span<const double> side, Ring& inside, Ring& outside) {
  for (size_t i = 0; i < ring.size(); ++i) {
    const size_t next = i + 1 < ring.size() ? i + 1 : 0;
    const Corner &a = ring[i], &b = ring[next];
    const double at_a = side[i], at_b = side[next];
    if (at_a <= 0) inside.push_back(a);
    if (at_a >= 0) outside.push_back(a);
    if ((at_a < 0 && at_b > 0) || (at_a > 0 && at_b < 0)) {
      const double t = at_a / (at_a - at_b);
      const Corner between{a.share + t * (b.share - a.share), a.x + t * (b.x - a.x)};
      inside.push_back(between), outside.push_back(between);
    }
  }
}

// A face of a sketch, in its poses.
struct SketchedFace {
  SketchedFace(const Sketch& sketch, int f) {
    const auto& [i, j, k] = sketch.faces[f];
    a = sketch.points[i];
    for (int axis = 0; axis < 3; ++axis) {
      ab[axis] = sketch.points[j][axis] - a[axis];
      ac[axis] = sketch.points[k][axis] - a[axis];
    }
  }
  std::array<FourFloats, 3> a, ab, ac;
};

// Per pose, the largest squared distance, m^2, of the corners of a piece from the points near them.
FourFloats farthest(const SketchedFace& face, const SketchedFace& near, std::span<const Cover::Corner> ring) {
  FourFloats most{};
  for (const auto& [share, there] : ring) {
    FourFloats squares{};
    for (int i = 0; i < 3; ++i) {
      const FourFloats apart = face.a[i] - near.a[i] + share.second * face.ab[i] + share.third * face.ac[i] -
                               there.second * near.ab[i] - there.third * near.ac[i];
      squares += apart * apart;
    }
    most = squares > most ? squares : most;
  }
  return most;
}

// Branch and bound. The distance to one face of `to` is a convex function, so over a polygon it is the
// largest at a corner, and with the right face that is a bound which is hardly too large. A piece that no
// face bounds well enough is cut along the outline of the face nearest to its middle: what lies over the face
// is done with, and the rest looks for faces of its own. So a large triangle over many small ones takes about
// one cut for each of them, however near it is.
class FarthestPoint {
 public:
  FarthestPoint(const PosedSurface& from, const PosedSurface& to, double known, double slack,
                Cover* found = nullptr)
      : from_(from),
        to_(to),
        lower_(known),
        slack_(slack),
        nothing_(kNothing * std::max(from.size(), to.size())),
        on_line_(kOnLine / kNothing * nothing_),
        found_(found) {}

  // Each face from the place where the one before it ended.
  void look_into_all() {
    for (int f = 0; f < from_.surface().face_count(); ++f) {
      const auto [a, b, c] = from_.triangle(f);
      ring_ = {{Vec3::UnitX(), a}, {Vec3::UnitY(), b}, {Vec3::UnitZ(), c}};
      push({f, 0, near_}, near_);
      look_into();
    }
  }

  // The farther there is a point, the less there is to do.
  void look_into(const Cover& cover, std::span<const int> pieces) {
    for (const int i : pieces) {
      const Cover::Piece& piece = cover.pieces[size_t(i)];
      ring_.clear();
      for (const Cover::Corner& c : cover.ring(size_t(i)))
        ring_.push_back({c.share, from_.at(piece.face, c.share)});
      push({piece.face, 0, piece.near}, piece.near);
      look_into();
    }
  }

  double squared_bound() const { return std::max(lower_, passed_); }

 private:
  double loose(double squared) const { return (1 + slack_) * (1 + slack_) * squared; }
  double allowed() const {
    const double within = found_ ? kCoverWithin * kCoverWithin * lower_ : lower_;
    return std::max(loose(within), nothing_ * nothing_);
  }

  ClosestPoint nearest(const Vec3& x, int guess) {
    const ClosestPoint there = to_.closest(x, guess);
    lower_ = std::max(lower_, there.squared);
    near_ = there.face;
    return there;
  }

  // Puts a suspect with the corners in ring_ on the stack, bounded by `face` if that is nearer.
  void push(Suspect suspect, int face) {
    suspect.begin = corners_.size();
    corners_.insert(corners_.end(), ring_.begin(), ring_.end());
    bound(suspect, face);
    waiting_.push_back(suspect);
  }

  // Depth first: what lies together is done together.
  void look_into() {
    while (!waiting_.empty()) {
      const Suspect suspect = waiting_.back();
      waiting_.pop_back();
      ring_.assign(corners_.begin() + std::ptrdiff_t(suspect.begin), corners_.end());
      corners_.resize(suspect.begin);
      if (suspect.upper > allowed()) {
        refine(suspect);
      } else {
        pass(suspect);
      }
    }
  }

  void bound(Suspect& suspect, int face) const {
    suspect.tried = face;
    double farthest = 0;
    for (const Corner& c : ring_) {
      farthest = std::max(farthest, to_.squared_distance(c.x, face));
      if (farthest >= suspect.upper) return;
    }
    suspect.upper = farthest, suspect.near = face;
  }

  void pass(const Suspect& suspect) {
    passed_ = std::max(passed_, suspect.upper);
    if (!found_) return;
    const auto [a, b, c] = to_.triangle(suspect.near);
    for (const Corner& corner : ring_)
      found_->corners.push_back({corner.share, closest_shares(corner.x, a, b, c)});
    found_->pieces.push_back({suspect.face, suspect.near, int(found_->corners.size())});
  }

  void refine(Suspect suspect) {
    Vec3 middle = Vec3::Zero();
    for (const Corner& c : ring_) middle += c.x;
    middle /= double(ring_.size());
    const ClosestPoint there = nearest(middle, suspect.near);
    if (there.face != suspect.tried) bound(suspect, there.face);
    double radius = 0;
    for (const Corner& c : ring_) radius = std::max(radius, (c.x - middle).norm());
    // Good for this pose alone: in another the piece would have to ask for its middle again.
    const double reach = std::sqrt(there.squared) + radius;
    if (!found_) suspect.upper = std::min(suspect.upper, reach * reach);
    if (suspect.upper <= std::max(allowed(), loose(there.squared)) || radius <= nothing_) {
      pass(suspect);
    } else {
      cut_along(suspect, there.face, middle);
    }
  }

  // A little beyond the face's edges, so that a piece which lies over the face is one with rounding and all.
  void cut_along(const Suspect& suspect, int face, const Vec3& middle) {
    const double margin = std::sqrt(allowed()) / 2;
    const auto corner = to_.triangle(face);
    const Vec3 n = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    bool is_cut = false;
    for (int k = 0; k < 3 && n.squaredNorm() > 0; ++k) {
      const Vec3& a = corner[k];
      const Vec3 across = (corner[(k + 1) % 3] - a).cross(n).normalized();
      find_sides([&](const Vec3& x) { return across.dot(x - a) - margin; });
      const auto [least, most] = std::ranges::minmax(sides_);
      if (!(-least > on_line_)) break;  // it lies beside the face
      if (!(most > on_line_)) continue;
      cut_off(suspect, face);
      is_cut = true;
    }
    if (is_cut) {
      push(suspect, face);
    } else {
      halve(suspect, middle);
    }
  }

  // Through the middle, across the way to the corner farthest from it.
  void halve(const Suspect& suspect, const Vec3& middle) {
    const auto nearer = [&](const Corner& a, const Corner& b) {
      return (a.x - middle).squaredNorm() < (b.x - middle).squaredNorm();
    };
    const Vec3 along = std::max_element(ring_.begin(), ring_.end(), nearer)->x - middle;
    find_sides([&](const Vec3& x) { return along.dot(middle - x); });
    cut_off(suspect, suspect.near);
    push(suspect, suspect.near);
  }

  template <class Side>
  void find_sides(const Side& side) {
    sides_.clear();
    for (const Corner& c : ring_) sides_.push_back(side(c.x));
  }

  // Leaves in ring_ what is inside, and makes what is outside a suspect of its own.
  void cut_off(const Suspect& suspect, int face) {
    inside_.clear(), outside_.clear();
    cut(ring_, sides_, inside_, outside_);
    ring_.swap(outside_);
    push(suspect, face);
    ring_.swap(inside_);
  }

  const PosedSurface &from_, &to_;
  double lower_;  // m^2: so far there is a point, or it does not matter
  double slack_;
  double nothing_, on_line_;   // metres
  double passed_ = 0;          // m^2: the largest bound of what is not looked into
  Ring ring_;                  // of the suspect that is looked into
  std::vector<double> sides_;  // of its corners, of a line to cut it along
  Ring inside_, outside_;      // of that
  std::vector<Suspect> waiting_;
  Ring corners_;  // of those that wait, one after another
  int near_ = 0;  // the face that was the nearest last
  Cover* found_;  // takes all that has passed, for other poses; or null, and the bound is for this one
};

}  // namespace

Cover cover(const PosedSurface& from, const PosedSurface& to, double known, double slack) {
  Cover found;
  FarthestPoint(from, to, known, slack, &found).look_into_all();
  return found;
}

Sketch::Sketch(const FaceTree& tree, const PerPose<std::vector<Vec3>>& posed, const PerPose<Vec3>& centres)
    : faces(tree.faces()), points(posed.front().size()) {
  for (size_t p = 0; p < posed.size(); ++p) {
    double farthest = 0;
    for (size_t v = 0; v < points.size(); ++v) {
      const Vec3 x = posed[p][v] - centres[p];
      for (int i = 0; i < 3; ++i) points[v][i][p] = float(x[i]);
      farthest = std::max(farthest, x.squaredNorm());
    }
    reach[p] = std::sqrt(farthest);
  }
}

Sketch::PerPose<std::vector<int>> doubts(const Sketch& from, const Sketch& to,
                                         const Sketch::PerPose<double>& known, const Cover& cover) {
  struct Doubt {
    float upper;  // m^2
    int piece;
  };
  FourFloats passes;
  for (size_t p = 0; p < known.size(); ++p) {
    const double nearer = std::sqrt(known[p]) - kRounding * (from.reach[p] + to.reach[p]);
    passes[p] = nearer > 0 ? float(nearer * nearer) : 0;
  }
  Sketch::PerPose<std::vector<Doubt>> doubts;
  for (size_t i = 0; i < cover.pieces.size(); ++i) {
    const Cover::Piece& piece = cover.pieces[i];
    const FourFloats upper =
        farthest(SketchedFace(from, piece.face), SketchedFace(to, piece.near), cover.ring(i));
    const auto is_nearer = upper < passes;
    if (is_nearer[0] & is_nearer[1] & is_nearer[2] & is_nearer[3]) continue;
    for (size_t p = 0; p < doubts.size(); ++p) {
      if (!is_nearer[p]) doubts[p].push_back({upper[p], int(i)});
    }
  }
  Sketch::PerPose<std::vector<int>> farthest_first;
  for (size_t p = 0; p < doubts.size(); ++p) {
    std::ranges::stable_sort(doubts[p], std::greater(), &Doubt::upper);
    for (const Doubt& doubt : doubts[p]) farthest_first[p].push_back(doubt.piece);
  }
  return farthest_first;
}

double squared_bound(const PosedSurface& from, const PosedSurface& to, double known, double slack,
                     const Cover& cover, std::span<const int> doubts) {
  FarthestPoint search(from, to, known, slack);
  search.look_into(cover, doubts);
  return search.squared_bound();
}

}  // namespace skinlod
