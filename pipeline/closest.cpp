// SPDX-License-Identifier: MIT
#include "pipeline/closest.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "pipeline/parallel.h"

namespace skinlod {
namespace {

// Boxes around more faces than these are divided on all threads.
constexpr size_t kSharedFaces = 4096;

// All but the last of the four in a box hold as many faces as fill them, so that hardly one is empty.
size_t fill_of(size_t faces) {
  size_t fill = 1;
  while (4 * fill < faces) fill *= 4;
  return fill;
}

// How many boxes these faces come in.
int boxes_for(size_t faces) {
  if (faces == 1) return 0;
  const size_t fill = fill_of(faces), full = (faces - 1) / fill;
  return int(1 + full * (fill - 1) / 3) + boxes_for(faces - full * fill);
}

}  // namespace

Vec3 closest_shares(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ax = x - a;
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Vec3 bx = x - b;
  const double d3 = ab.dot(bx), d4 = ac.dot(bx);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double t = d1 - d3 > 0 ? d1 / (d1 - d3) : 0;
    return {1 - t, t, 0};
  }
  const Vec3 cx = x - c;
  const double d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 - d6 > 0 ? d2 / (d2 - d6) : 0;
    return {1 - t, 0, t};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double span = (d4 - d3) + (d5 - d6), t = span > 0 ? (d4 - d3) / span : 0;
    return {0, 1 - t, t};
  }
  const double sum = va + vb + vc;
  if (!(sum > 0)) return {1, 0, 0};
  return {1 - vb / sum - vc / sum, vb / sum, vc / sum};
}

FaceTree::FaceTree(const Surface& surface) : surface_(surface) {
  std::vector<Vec3> middle;
  for (int f = 0; f < surface.face_count(); ++f) {
    vertices_.push_back(triangle_vertices(surface, f));
    const auto& [a, b, c] = vertices_.back();
    middle.push_back((surface.position[a] + surface.position[b] + surface.position[c]) / 3);
  }
  std::vector<int> faces(middle.size());
  std::iota(faces.begin(), faces.end(), 0);
  boxes_.resize(size_t(std::max(1, boxes_for(faces.size()))), {kEmpty, kEmpty, kEmpty, kEmpty});
  divide(0, faces, middle);
}

// Faces are divided where they are spread the farthest: in two, and both halves again.
void FaceTree::divide(int box, std::span<int> faces, std::span<const Vec3> middle) {
  const auto part = [&](std::span<int> all, size_t before) {
    if (before >= all.size()) return;
    Vec3 low = middle[all.front()], high = low;
    for (const int f : all) low = low.cwiseMin(middle[f]), high = high.cwiseMax(middle[f]);
    int along = 0;
    (high - low).maxCoeff(&along);
    std::nth_element(all.begin(), all.begin() + std::ptrdiff_t(before), all.end(), [&](int f, int g) {
      return std::pair(middle[f][along], f) < std::pair(middle[g][along], g);
    });
  };
  const size_t count = faces.size(), fill = fill_of(count);
  part(faces, 2 * fill);
  part(faces.first(std::min(2 * fill, count)), fill);
  if (count > 2 * fill) part(faces.subspan(2 * fill), fill);

  std::array<std::span<int>, 4> in;
  int next = box + 1;
  for (size_t k = 0; k * fill < count; ++k) {
    in[k] = faces.subspan(k * fill, std::min(fill, count - k * fill));
    boxes_[box][k] = in[k].size() == 1 ? ~in[k].front() : next;
    next += boxes_for(in[k].size());
  }
  const auto go_on = [&](int k) {
    if (in[k].size() > 1) divide(boxes_[box][k], in[k], middle);
  };
  if (count > kSharedFaces) {
    parallel_for(4, go_on);
  } else {
    for (int k = 0; k < 4; ++k) go_on(k);
  }
}

PosedSurface::PosedSurface(const Surface& surface, std::vector<Vec3> points)
    : PosedSurface(std::make_shared<FaceTree>(surface), std::move(points)) {}

PosedSurface::PosedSurface(std::shared_ptr<const FaceTree> tree, std::vector<Vec3> points)
    : tree_(std::move(tree)), points_(std::move(points)), boxes_(tree_->boxes().size()) {
  Vec3 low = points_.front(), high = low;
  for (const Vec3& x : points_) low = low.cwiseMin(x), high = high.cwiseMax(x);
  centre_ = (low + high) / 2, size_ = (high - low).norm();
  fit_boxes();
}

// What is in a box comes after it, so from the last to the first.
void PosedSurface::fit_boxes() {
  struct Box {
    FourFloats low, high;  // three of the four
  };
  constexpr float kFar = std::numeric_limits<float>::infinity();
  const auto lower = [](const FourFloats& a, const FourFloats& b) { return a < b ? a : b; };
  const auto higher = [](const FourFloats& a, const FourFloats& b) { return a > b ? a : b; };
  const auto both = [&](const Box& a, const Box& b) {
    return Box{lower(a.low, b.low), higher(a.high, b.high)};
  };
  std::vector<FourFloats> local;
  local.reserve(points_.size());
  for (const Vec3& x : points_) local.push_back(floats(x - centre_));
  const auto tree = tree_->boxes();
  std::vector<Box> around(tree.size());
  const auto around_what_is_in = [&](int in) {
    if (in > 0) return around[in];
    if (in == FaceTree::kEmpty) return Box{FourFloats{} + kFar, FourFloats{} - kFar};
    const auto& [i, j, k] = tree_->faces()[~in];
    const FourFloats &a = local[i], &b = local[j], &c = local[k];
    return Box{lower(lower(a, b), c), higher(higher(a, b), c)};
  };
  for (size_t box = tree.size(); box-- > 0;) {
    const auto& in = boxes_[box].in = tree[box];
    const Box a = around_what_is_in(in[0]), b = around_what_is_in(in[1]), c = around_what_is_in(in[2]),
              d = around_what_is_in(in[3]);
    for (int i = 0; i < 3; ++i) {
      boxes_[box].low[i] = FourFloats{a.low[i], b.low[i], c.low[i], d.low[i]};
      boxes_[box].high[i] = FourFloats{a.high[i], b.high[i], c.high[i], d.high[i]};
    }
    around[box] = both(both(a, b), both(c, d));
  }
}

double PosedSurface::squared_distance(const Vec3& x, int f) const {
  const auto& [a, b, c] = tree_->faces()[f];
  return (x - at(f, closest_shares(x, points_[a], points_[b], points_[c]))).squaredNorm();
}

void PosedSurface::consider(const Vec3& x, int f, ClosestPoint& best) const {
  const auto& [a, b, c] = tree_->faces()[f];
  const Vec3 share = closest_shares(x, points_[a], points_[b], points_[c]);
  const double squared = (x - at(f, share)).squaredNorm();
  if (squared < best.squared || (squared == best.squared && f < best.face)) best = {squared, f, share};
}

// Depth first, and of four boxes the nearest first: with a good guess the order of the others hardly matters,
// and what is not sorted needs no branches. `waiting` has room for three of each of the 16 boxes, one in
// another, that 2^31 faces make, and for four.
template <class Counts>
ClosestPoint PosedSurface::closest_of(const Vec3& x, int guess, const Counts& counts) const {
  const Vec3 local = x - centre_;
  const std::array about = {FourFloats{} + float(local.x()), FourFloats{} + float(local.y()),
                            FourFloats{} + float(local.z())};
  const double room = 1e-6 * (size_ + local.norm());  // metres by which the floats may be wrong
  ClosestPoint best{std::numeric_limits<double>::infinity()};
  float reach = std::numeric_limits<float>::infinity();
  const auto look_at = [&](int f) {
    if (!counts(f)) return;
    consider(x, f, best);
    const double radius = std::sqrt(best.squared) + room;
    reach = float(radius * radius * (1 + 1e-5));
  };
  const auto squared_distances = [&](const Boxes& boxes) {
    FourFloats squared{};
    for (size_t i = 0; i < 3; ++i) {
      const FourFloats below = boxes.low[i] - about[i], above = about[i] - boxes.high[i];
      const FourFloats outside = below > above ? below : above;
      const FourFloats positive = outside > 0 ? outside : 0;
      squared += positive * positive;
    }
    return squared;
  };
  look_at(guess);

  std::array<int, 64> waiting;
  std::array<float, 64> squared;  // distances of those
  size_t count = 0;
  waiting[count] = 0, squared[count++] = 0;
  while (count > 0) {
    const int in = waiting[--count];
    if (squared[count] > reach) continue;
    if (in < 0) {
      if (~in != guess) look_at(~in);
      continue;
    }
    const Boxes& four = boxes_[in];
    const FourFloats distances = squared_distances(four);
    const size_t first = count;
    for (int k = 0; k < 4; ++k) {
      waiting[count] = four.in[k], squared[count] = distances[k];
      count += size_t((distances[k] <= reach) & (four.in[k] != FaceTree::kEmpty));
    }
    for (size_t i = first; i + 1 < count; ++i) {
      if (squared[i] < squared[count - 1])
        std::swap(squared[i], squared[count - 1]), std::swap(waiting[i], waiting[count - 1]);
    }
  }
  return best;
}

ClosestPoint PosedSurface::closest(const Vec3& x, int guess) const {
  return closest_of(x, guess, [](int) { return true; });
}

ClosestPoint PosedSurface::closest_facing(const Vec3& x, const Vec3& direction, int guess) const {
  return closest_of(x, guess, [&](int f) { return normal(f).dot(direction) >= 0; });
}

}  // namespace skinlod
