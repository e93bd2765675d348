// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "pipeline/rotation.h"
#include "tests/random.h"

using namespace skinlod;

namespace {

using std::numbers::pi;

Quat random_rotation(std::mt19937& random) {
  Quat q;
  do {
    for (double& x : q) x = uniform(random, -1, 1);
  } while (q.norm() > 1 || q.norm() < 0.1);
  return q.normalized();
}

// The angle between two rotations, radians; exact enough near 0.
double between(const Quat& a, const Quat& b) {
  return 4 * std::asin(std::min(1.0, std::min((a - b).norm(), (a + b).norm()) / 2));
}

}  // namespace

TEST_SUITE("rotation") {
  TEST_CASE("sine and cosine are right to 1e-15 up to a million radians") {
    std::mt19937 random(1);
    for (const double range : {1e-12, 1e-3, 1.0, 10.0, 1e3, 1e6}) {
      double worst = 0, worst_relative = 0;
      for (int i = 0; i < 20000; ++i) {
        const double angle = uniform(random, -range, range);
        const SinCos got = sin_cos(angle);
        const long double sine = std::sin(static_cast<long double>(angle));
        worst = std::max({worst, double(std::abs(got.sin - sine)),
                          double(std::abs(got.cos - std::cos(static_cast<long double>(angle))))});
        if (std::abs(angle) < 0.7 && angle != 0) {
          worst_relative = std::max(worst_relative, double(std::abs((got.sin - sine) / sine)));
        }
      }
      CAPTURE(range);
      CHECK(worst < 4e-16);
      CHECK(worst_relative < 4e-16);
    }
  }

  TEST_CASE("sine and cosine are right beside every quarter turn") {
    double worst = 0;
    for (int quarter = -3000; quarter <= 3000; ++quarter) {
      for (const double off : {-1e-9, 0.0, 1e-9, -pi / 4, pi / 4}) {
        const double angle = quarter * (pi / 2) + off;
        const SinCos got = sin_cos(angle);
        worst = std::max({worst, std::abs(got.sin - std::sin(angle)), std::abs(got.cos - std::cos(angle))});
      }
    }
    CHECK(worst < 4e-16);
    CHECK(sin_cos(0).sin == 0);
    CHECK(sin_cos(0).cos == 1);
  }

  TEST_CASE("the angle of a vector is right to 1e-15 in every direction and at every length") {
    std::mt19937 random(2);
    for (const double y_scale : {1e-300, 1e-12, 1e-3, 1.0, 1e3, 1e12, 1e300}) {
      double worst = 0, worst_relative = 0;
      for (int i = 0; i < 20000; ++i) {
        const double y = uniform(random, -1, 1) * y_scale, x = uniform(random, -1, 1);
        const double got = atan2_exact(y, x), truth = std::atan2(y, x);
        worst = std::max(worst, std::abs(got - truth));
        worst_relative = std::max(worst_relative, std::abs((got - truth) / truth));
      }
      CAPTURE(y_scale);
      CHECK(worst < 1e-15);
      CHECK(worst_relative < 1e-15);
    }
    CHECK(atan2_exact(0, 0) == 0);
    CHECK(atan2_exact(0, 1) == 0);
    CHECK(atan2_exact(0, -1) == pi);
    CHECK(atan2_exact(1, 0) == pi / 2);
    CHECK(atan2_exact(-1, 0) == -pi / 2);
    CHECK(atan2_exact(1, 1) == doctest::Approx(pi / 4).epsilon(1e-15));
  }

  TEST_CASE("a quarter turn about z takes x to y") {
    const Quat q = turn(Vec3(0, 0, 1), pi / 2);
    CHECK((matrix(q) * Vec3(1, 0, 0) - Vec3(0, 1, 0)).norm() < 1e-15);
    CHECK((q - Quat(0, 0, std::sqrt(0.5), std::sqrt(0.5))).norm() < 1e-15);
  }

  TEST_CASE("multiplied quaternions are multiplied matrices") {
    std::mt19937 random(3);
    for (int i = 0; i < 200; ++i) {
      const Quat a = random_rotation(random), b = random_rotation(random);
      CHECK((matrix(multiply(a, b)) - matrix(a) * matrix(b)).norm() < 1e-14);
    }
  }

  TEST_CASE("a rotation matrix gives its quaternion back up to sign") {
    std::mt19937 random(4);
    for (int i = 0; i < 2000; ++i) {
      const Quat q = random_rotation(random);
      CHECK(std::abs(quaternion(matrix(q)).dot(q)) == doctest::Approx(1).epsilon(1e-14));
    }
    // Half turns, where the trace is -1 and w is 0.
    for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0.6, 0, -0.8)}) {
      CHECK((matrix(quaternion(matrix(turn(axis, pi)))) - matrix(turn(axis, pi))).norm() < 1e-14);
    }
  }

  TEST_CASE("a rotation vector is what turn undoes") {
    std::mt19937 random(5);
    for (const double size : {0.0, 1e-12, 1e-3, 1.0, 3.14}) {
      for (int i = 0; i < 200; ++i) {
        const Vec3 axis = random_vector(random, 1);
        const Vec3 r = axis.normalized() * size;
        CHECK((rotation_vector(turn(r)) - r).norm() < 1e-14);
        CHECK((rotation_vector(Quat(-turn(r))) - r).norm() < 1e-14);
      }
    }
  }

  TEST_CASE("slerp turns at constant speed along the shorter arc") {
    std::mt19937 random(6);
    for (int i = 0; i < 500; ++i) {
      const Quat a = random_rotation(random), b = random_rotation(random);
      const double whole = between(a, b);
      REQUIRE(whole <= pi + 1e-12);
      for (const double t : {0.0, 0.1, 0.25, 0.5, 0.9, 1.0}) {
        CAPTURE(i);
        CAPTURE(t);
        const Quat q = slerp(a, b, t);
        CHECK(q.norm() == doctest::Approx(1).epsilon(1e-14));
        CHECK(between(a, q) == doctest::Approx(t * whole).epsilon(1e-7));
        CHECK(between(q, b) == doctest::Approx((1 - t) * whole).epsilon(1e-7));
      }
    }
  }

  TEST_CASE("slerp between nearly equal and between opposite quaternions is steady") {
    const Quat a = turn(Vec3(0.6, 0, 0.8), 1.0);
    for (const double step : {0.0, 1e-16, 1e-10, 0.9e-8, 1.1e-8, 1e-6}) {
      const Quat b = turn(Vec3(0.6, 0, 0.8), 1.0 + step);
      CHECK((slerp(a, b, 0.5) - turn(Vec3(0.6, 0, 0.8), 1.0 + step / 2)).norm() < 4e-16);
    }
    CHECK((slerp(a, -a, 0.3) - a).norm() < 4e-16);
    // Half a turn apart both arcs are the shorter one; any of them will do.
    const Quat half = multiply(turn(Vec3(0, 1, 0), pi), a);
    CHECK(between(a, slerp(a, half, 0.5)) == doctest::Approx(pi / 2).epsilon(1e-9));
  }

  TEST_CASE("a quaternion without length is the identity") {
    CHECK(normalised(Quat::Zero()) == Quat(0, 0, 0, 1));
    CHECK(normalised(Quat(0, NAN, 0, 1)) == Quat(0, 0, 0, 1));
    CHECK(normalised(Quat(0, 0, 0, 2)) == Quat(0, 0, 0, 1));
  }
}
