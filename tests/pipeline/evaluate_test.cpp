// SPDX-License-Identifier: MIT
#include "pipeline/evaluate.h"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

PosedError between(const Surface& a, const Surface& b, const Pose& pose, int samples = 4000) {
  const Surface* other[] = {&b};
  return posed_errors(a, other, {&pose, 1}, samples).front().front();
}

const Pose kStill{"bind", Palette(8, identity())};

}  // namespace

TEST_SUITE("evaluate") {
  TEST_CASE("a surface has no distance from itself in any pose") {
    const Surface s = bending_tube(16, 16, 4).surface;
    for (unsigned seed = 0; seed < 3; ++seed) {
      const PosedError e = between(s, s, {"random", random_palette(4, seed, 1, 1)});
      CHECK(e.max < 1e-12);
    }
  }

  TEST_CASE("a flat sheet moved along its normal is that far away") {
    Surface s = grid_box(Vec3(1, 1, 1), 4), up = s;
    s.corners.resize(96), s.face_begin.resize(33);
    up.corners = s.corners, up.face_begin = s.face_begin;
    const Vec3 n = (s.position[s.corners[1]] - s.position[s.corners[0]])
                       .cross(s.position[s.corners[2]] - s.position[s.corners[0]])
                       .normalized();
    for (Vec3& x : up.position) x += 0.25 * n;
    const PosedError e = between(s, up, kStill);
    CHECK(e.rms == doctest::Approx(0.25));
    CHECK(e.max == doctest::Approx(0.25));
  }

  TEST_CASE("concentric spheres are apart by the difference of their radii") {
    const Surface s = sphere(5);
    Surface larger = s;
    for (Vec3& x : larger.position) x *= 1.1;
    CHECK(between(s, larger, kStill).rms == doctest::Approx(0.1).epsilon(0.01));
  }

  TEST_CASE("a missing part is seen from one side and counts there") {
    Surface whole = sphere(4), half = whole;
    half.corners.clear(), half.face_begin = {0};
    for (int f = 0; f < whole.face_count(); ++f) {
      double y = 0;
      for (const int w : whole.face(f)) y += whole.position[w].y();
      if (y > 0) half.add_face(whole.face(f));
    }
    const PosedError a = between(whole, half, kStill), b = between(half, whole, kStill);
    CHECK(a.max == doctest::Approx(std::sqrt(2.0)).epsilon(0.02));  // the south pole to the equator
    CHECK(a.rms == doctest::Approx(b.rms).epsilon(0.02));           // both directions are in either
  }

  TEST_CASE("the pose counts: weights alone make a distance") {
    const Surface s = bending_tube(16, 16, 4).surface;
    Surface stiff = s;
    for (Influences& i : stiff.influences) i = {{0, 1.0}};
    CHECK(between(s, stiff, kStill).max < 1e-12);
    Pose pose = kStill;
    for (int b = 1; b < 8; ++b) pose.palette[b].col(3) = Vec3(0.5, 0, 0);
    CHECK(between(s, stiff, pose).max > 0.3);
  }

  TEST_CASE("far from the origin the distance keeps its digits") {
    const Surface s = sphere(4);
    Surface larger = s;
    for (Vec3& x : larger.position) x *= 1.001;
    Pose far = kStill;
    for (Affine& T : far.palette) T.col(3) = Vec3(1000, -2000, 500);
    CHECK(between(s, larger, far).rms == doctest::Approx(between(s, larger, kStill).rms).epsilon(1e-6));
  }

  TEST_CASE("one thread and two give the same bits") {
    const Surface s = bending_tube(16, 16, 4).surface, t = bending_tube(9, 8, 4).surface;
    std::vector<Pose> poses;
    for (unsigned seed = 0; seed < 6; ++seed) poses.push_back({"random", random_palette(4, seed, 1, 1)});
    const auto run = [&](size_t threads) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      const Surface* other[] = {&t};
      return posed_errors(s, other, poses).front();
    };
    const auto one = run(1), two = run(2);
    for (size_t p = 0; p < poses.size(); ++p) {
      CHECK(one[p].rms == two[p].rms);
      CHECK(one[p].max == two[p].max);
      CHECK(one[p].rms > 0);
    }
  }
}
