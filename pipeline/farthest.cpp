// SPDX-License-Identifier: MIT
#include "pipeline/farthest.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

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

// Distances that are found in floats may be off by so much of the size.
constexpr double kRounding = 1e-6;

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
};

// The part of the ring where `side` is not positive, and the part where it is not negative.
struct Halves {
  Ring inside, outside;
};
template <class Side>
Halves cut(const Ring& ring, const Side& side) {
  Halves halves;
  halves.inside.reserve(ring.size() + 1), halves.outside.reserve(ring.size() + 1);
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

// A triangle about `centre`, three of the four floats of each corner.
struct FloatFace {
  FloatFace(const std::array<Vec3, 3>& corners, const Vec3& centre)
      : a(floats(corners[0] - centre)),
        ab(floats(corners[1] - corners[0])),
        ac(floats(corners[2] - corners[0])) {}
  FourFloats at(const Cover::Share& share) const { return a + share.second * ab + share.third * ac; }
  static FourFloats floats(const Vec3& x) { return FourFloats{float(x[0]), float(x[1]), float(x[2]), 0}; }
  FourFloats a, ab, ac;
};

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
      const auto& [a, b, c] = from_.triangle(f);
      Suspect whole{f, {{Vec3::UnitX(), a}, {Vec3::UnitY(), b}, {Vec3::UnitZ(), c}}, near_};
      bound(whole, near_);
      look_into(std::move(whole));
    }
  }

  // A point of the near face for each corner tells, in floats, that most pieces are nearer than some point is
  // known to be; the others are looked at closely, those first that may be the farthest: the farther there is
  // a point, the less there is to do.
  void look_over(const Cover& cover) {
    struct Doubt {
      float upper;
      size_t piece;
    };
    std::vector<Doubt> doubts;
    const Vec3 centre = from_.at(0, Vec3::UnitX());
    const double room = kRounding * (from_.size() + to_.size());
    const double nearer = std::max(std::sqrt(lower_) - room, 0.0);
    const auto passes = float(nearer * nearer);
    std::optional<FloatFace> face;
    for (size_t i = 0; i < cover.pieces.size(); ++i) {
      const Cover::Piece& piece = cover.pieces[i];
      if (i == 0 || piece.face != cover.pieces[i - 1].face) face.emplace(from_.triangle(piece.face), centre);
      const FloatFace near(to_.triangle(piece.near), centre);
      float upper = 0;
      for (const Cover::Corner& c : cover.ring(i)) {
        const FourFloats apart = face->at(c.share) - near.at(c.there), squares = apart * apart;
        upper = std::max(upper, squares[0] + squares[1] + squares[2]);
      }
      if (!(upper < passes)) doubts.push_back({upper, i});
    }
    std::ranges::stable_sort(doubts, std::greater(), &Doubt::upper);
    for (const Doubt& doubt : doubts) look_into(suspect(cover, doubt.piece));
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

  // Depth first: what lies together is done together.
  void look_into(Suspect whole) {
    waiting_.push_back(std::move(whole));
    while (!waiting_.empty()) {
      Suspect suspect = std::move(waiting_.back());
      waiting_.pop_back();
      if (suspect.upper > allowed()) {
        refine(std::move(suspect));
      } else {
        pass(suspect);
      }
    }
  }

  Suspect suspect(const Cover& cover, size_t i) const {
    const Cover::Piece& piece = cover.pieces[i];
    Suspect suspect{piece.face, {}, piece.near};
    for (const Cover::Corner& c : cover.ring(i))
      suspect.ring.push_back({c.share, from_.at(piece.face, c.share)});
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
    const auto& [a, b, c] = to_.triangle(suspect.near);
    for (const Corner& corner : suspect.ring)
      found_->corners.push_back({corner.share, closest_shares(corner.x, a, b, c)});
    found_->pieces.push_back({suspect.face, suspect.near, int(found_->corners.size())});
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
    if (suspect.upper <= std::max(allowed(), loose(there.squared)) || radius <= nothing_) {
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
    waiting_.push_back(std::move(part));
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
  std::vector<Suspect> waiting_;
  int near_ = 0;  // the face that was the nearest last
  Cover* found_;  // takes all that has passed, for other poses; or null, and the bound is for this one
};

}  // namespace

Cover cover(const PosedSurface& from, const PosedSurface& to, double known, double slack) {
  Cover found;
  FarthestPoint(from, to, known, slack, &found).look_into_all();
  return found;
}

double squared_bound(const PosedSurface& from, const PosedSurface& to, double known, double slack,
                     const Cover& cover) {
  FarthestPoint search(from, to, known, slack);
  search.look_over(cover);
  return search.squared_bound();
}

}  // namespace skinlod
