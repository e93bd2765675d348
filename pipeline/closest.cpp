// SPDX-License-Identifier: MIT
#include "pipeline/closest.h"

#include <embree3/rtcore.h>

#include <cmath>
#include <limits>

namespace skinlod {
namespace {

// One for the whole process: it holds no geometry, and making one takes longer than many a query.
RTCDevice device() {
  static const RTCDevice one = rtcNewDevice("threads=1,set_affinity=0");
  return one;
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

struct PosedSurface::Search {
  const PosedSurface* surface;
  Vec3 x;
  double room;  // metres by which Embree's floats may be wrong
  ClosestPoint best;

  float radius() const { return float((std::sqrt(best.squared) + room) * (1 + 1e-5)); }
};

void PosedSurface::Release::operator()(void* scene) const { rtcReleaseScene(static_cast<RTCScene>(scene)); }

PosedSurface::PosedSurface(const Surface& surface, std::vector<Vec3> points)
    : surface_(surface), points_(std::move(points)) {
  Vec3 low = points_.front(), high = low;
  for (const Vec3& x : points_) low = low.cwiseMin(x), high = high.cwiseMax(x);
  centre_ = (low + high) / 2, size_ = (high - low).norm();

  const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), points_.size()));
  auto* index =
      static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                     3 * sizeof(unsigned), size_t(surface.face_count())));
  for (const Vec3& x : points_) {
    for (int i = 0; i < 3; ++i) *vertex++ = float(x[i] - centre_[i]);
  }
  for (int f = 0; f < surface.face_count(); ++f) {
    const auto [a, b, c] = triangle_vertices(surface, f);
    triangles_.push_back({points_[a], points_[b], points_[c]});
    for (const int v : {a, b, c}) *index++ = unsigned(v);
  }
  rtcCommitGeometry(geometry);
  const RTCScene scene = rtcNewScene(device());
  scene_.reset(scene);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
}

double PosedSurface::squared_distance(const Vec3& x, int f) const {
  const auto& [a, b, c] = triangles_[f];
  return (x - at(f, closest_shares(x, a, b, c))).squaredNorm();
}

void PosedSurface::consider(Search& search, int f) const {
  const auto& [a, b, c] = triangles_[f];
  const Vec3 share = closest_shares(search.x, a, b, c);
  const double squared = (search.x - at(f, share)).squaredNorm();
  const bool closer =
      squared < search.best.squared || (squared == search.best.squared && f < search.best.face);
  if (closer) search.best = {squared, f, share};
}

ClosestPoint PosedSurface::closest(const Vec3& x, int guess) const {
  const Vec3 local = x - centre_;
  Search search{this, x, 1e-5 * size_ + 1e-6 * local.norm(), {std::numeric_limits<double>::infinity()}};
  consider(search, guess);
  RTCPointQuery query{float(local.x()), float(local.y()), float(local.z()), 0, search.radius()};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const auto visit = [](RTCPointQueryFunctionArguments* args) {
    auto& s = *static_cast<Search*>(args->userPtr);
    const double before = s.best.squared;
    s.surface->consider(s, int(args->primID));
    if (!(s.best.squared < before)) return false;
    args->query->radius = s.radius();
    return true;
  };
  rtcPointQuery(static_cast<RTCScene>(scene_.get()), &query, &context, visit, &search);
  return search.best;
}

}  // namespace skinlod
