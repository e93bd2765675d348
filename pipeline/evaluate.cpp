// SPDX-License-Identifier: MIT
#include "pipeline/evaluate.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "pipeline/parallel.h"

namespace skinlod {
namespace {

struct Sample {
  std::array<int, 3> vertex;
  Vec3 share;  // barycentric
};

std::array<int, 3> vertices(const Surface& s, int f) {
  const auto face = s.face(f);
  return {s.wedges[face[0]].vertex, s.wedges[face[1]].vertex, s.wedges[face[2]].vertex};
}

// Stratified by area: sample i lies in the face that holds the middle of the i-th of `count` equal shares of
// the area, at the i-th point of a sequence that fills the unit square evenly (Roberts' R2).
std::vector<Sample> sample_by_area(const Surface& s, int count) {
  std::vector<double> until(size_t(s.face_count()));
  double area = 0;
  for (int f = 0; f < s.face_count(); ++f) {
    const auto [a, b, c] = vertices(s, f);
    area += (s.position[b] - s.position[a]).cross(s.position[c] - s.position[a]).norm() / 2;
    until[f] = area;
  }
  std::vector<Sample> samples;
  for (int i = 0; i < count && !until.empty(); ++i) {
    const double at = area * (i + 0.5) / count;
    const auto f = std::min(std::upper_bound(until.begin(), until.end(), at) - until.begin(),
                            std::ptrdiff_t(until.size()) - 1);
    double u = std::fmod(0.5 + 0.7548776662466927 * i, 1.0), v = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    samples.push_back({vertices(s, int(f)), Vec3(1 - u - v, u, v)});
  }
  return samples;
}

// The point of triangle abc closest to x (Ericson, Real-Time Collision Detection, 5.1.5).
Vec3 closest_point(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ax = x - a;
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3 bx = x - b;
  const double d3 = ab.dot(bx), d4 = ac.dot(bx);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return d1 - d3 > 0 ? Vec3(a + d1 / (d1 - d3) * ab) : a;
  const Vec3 cx = x - c;
  const double d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return d2 - d6 > 0 ? Vec3(a + d2 / (d2 - d6) * ac) : a;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double span = (d4 - d3) + (d5 - d6);
    return span > 0 ? Vec3(b + (d4 - d3) / span * (c - b)) : b;
  }
  const double sum = va + vb + vc;
  return sum > 0 ? Vec3(a + vb / sum * ab + vc / sum * ac) : a;
}

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release>;
using Scene = std::unique_ptr<std::remove_pointer_t<RTCScene>, Release>;

// A posed surface that knows the distance to the closest of its points. Embree holds floats about `centre`
// and only narrows the search; distances are ours, in double, and the search radius has room for the
// rounding, so that the result does not depend on the CPU's instructions.
class PosedSurface {
 public:
  PosedSurface(RTCDevice device, const Surface& surface, std::vector<Vec3> points, const Vec3& centre,
               double size)
      : surface_(surface), points_(std::move(points)), centre_(centre), room_(1e-5 * size) {
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), points_.size()));
    auto* index =
        static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                       3 * sizeof(unsigned), size_t(surface.face_count())));
    for (const Vec3& x : points_) {
      for (int i = 0; i < 3; ++i) *vertex++ = float(x[i] - centre_[i]);
    }
    for (int f = 0; f < surface.face_count(); ++f) {
      for (const int v : vertices(surface, f)) *index++ = unsigned(v);
    }
    rtcCommitGeometry(geometry);
    scene_.reset(rtcNewScene(device));
    rtcAttachGeometry(scene_.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_.get());
  }

  Vec3 at(const Sample& s) const {
    return s.share[0] * points_[s.vertex[0]] + s.share[1] * points_[s.vertex[1]] +
           s.share[2] * points_[s.vertex[2]];
  }

  double squared_distance(const Vec3& x) const {
    Search search{this, x, std::numeric_limits<double>::infinity()};
    const Vec3 local = x - centre_;
    RTCPointQuery query{float(local.x()), float(local.y()), float(local.z()), 0,
                        std::numeric_limits<float>::infinity()};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_.get(), &query, &context, &visit, &search);
    return search.best;
  }

 private:
  struct Search {
    const PosedSurface* surface;
    Vec3 x;
    double best;
  };

  static bool visit(RTCPointQueryFunctionArguments* args) {
    auto& search = *static_cast<Search*>(args->userPtr);
    const PosedSurface& self = *search.surface;
    const auto [a, b, c] = vertices(self.surface_, int(args->primID));
    const Vec3 nearest = closest_point(search.x, self.points_[a], self.points_[b], self.points_[c]);
    const double squared = (search.x - nearest).squaredNorm();
    if (!(squared < search.best)) return false;
    search.best = squared;
    args->query->radius = float((std::sqrt(squared) + self.room_) * (1 + 1e-5));
    return true;
  }

  const Surface& surface_;
  std::vector<Vec3> points_;
  Vec3 centre_;
  double room_;  // metres by which floats may be wrong
  Scene scene_;
};

struct Sums {
  double squared = 0, worst = 0;
  int count = 0;
  void add(const PosedSurface& from, const std::vector<Sample>& samples, const PosedSurface& to) {
    for (const Sample& s : samples) {
      const double d = to.squared_distance(from.at(s));
      squared += d, worst = std::max(worst, d), ++count;
    }
  }
};

}  // namespace

std::vector<std::vector<PosedError>> posed_errors(const Surface& original,
                                                  std::span<const Surface* const> levels,
                                                  std::span<const Pose> poses, int samples) {
  const Device device(rtcNewDevice("threads=1,set_affinity=0"));
  const auto on_original = sample_by_area(original, samples);
  std::vector<std::vector<Sample>> on_level;
  for (const Surface* level : levels) on_level.push_back(sample_by_area(*level, samples));

  std::vector<std::vector<PosedError>> errors(levels.size(), std::vector<PosedError>(poses.size()));
  parallel_for(int(poses.size()), [&](int p) {
    const auto points = pose_vertices(original, poses[p].palette);
    Vec3 low = points.front(), high = points.front();
    for (const Vec3& x : points) low = low.cwiseMin(x), high = high.cwiseMax(x);
    const Vec3 centre = (low + high) / 2;
    const double size = (high - low).norm();
    const PosedSurface source(device.get(), original, points, centre, size);
    for (size_t l = 0; l < levels.size(); ++l) {
      const PosedSurface level(device.get(), *levels[l], pose_vertices(*levels[l], poses[p].palette), centre,
                               size);
      Sums sums;
      sums.add(source, on_original, level);
      sums.add(level, on_level[l], source);
      errors[l][p] = {std::sqrt(sums.squared / std::max(1, sums.count)), std::sqrt(sums.worst)};
    }
  });
  return errors;
}

PosedError total(std::span<const PosedError> errors) {
  PosedError sum;
  for (const PosedError& e : errors) {
    sum.rms += e.rms * e.rms;
    sum.max = std::max(sum.max, e.max);
  }
  if (!errors.empty()) sum.rms = std::sqrt(sum.rms / double(errors.size()));
  return sum;
}

}  // namespace skinlod
