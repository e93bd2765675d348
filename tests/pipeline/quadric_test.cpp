// SPDX-License-Identifier: MIT
#include "pipeline/quadric.h"

#include <doctest/doctest.h>
#include <Eigen/SVD>
#include <random>

#include "tests/topology.h"

using namespace skinlod;

TEST_SUITE("quadric") {
  TEST_CASE("a plane's quadric is the weighted squared distance") {
    const Quadric q = plane_quadric(Vec3(0, 0, 3), Vec3(0, 0, 1), 2);
    CHECK(q(Vec3(7, -1, 3)) == doctest::Approx(0));
    CHECK(q(Vec3(7, -1, 5)) == doctest::Approx(8));
  }

  TEST_CASE("on a plane the minimum stays beside the point asked for") {
    const Quadric q = plane_quadric(Vec3(0, 0, 3), Vec3(0, 0, 1), 2);
    CHECK((minimum(q, Vec3(7, -1, 8)) - Vec3(7, -1, 3)).norm() < 1e-9);
  }

  TEST_CASE("three planes meet in their corner") {
    const Vec3 corner(1, 2, 3);
    Quadric q;
    for (const Vec3& n : {Vec3(1, 0, 0), Vec3(0.6, 0.8, 0), Vec3(0, 0.6, -0.8)})
      q += plane_quadric(corner, n, 0.5);
    CHECK((minimum(q, Vec3(9, 9, 9)) - corner).norm() < 1e-8);
    CHECK(q(corner) == doctest::Approx(0));
  }

  TEST_CASE("an empty quadric leaves the point where it is") {
    CHECK(minimum(Quadric{}, Vec3(1, 2, 3)) == Vec3(1, 2, 3));
  }

  TEST_CASE("the minimum is that of the dense pseudo-inverse") {
    std::mt19937 random(3);
    const auto unit = [&] { return double(random()) / double(std::mt19937::max()) * 2 - 1; };
    for (int trial = 0; trial < 200; ++trial) {
      CAPTURE(trial);
      Quadric q;
      const int planes = 1 + trial % 5;
      for (int i = 0; i < planes; ++i) {
        q += plane_quadric(Vec3(unit(), unit(), unit()), Vec3(unit(), unit(), unit()).normalized(),
                           1 + unit() / 2);
      }
      const Vec3 near(unit(), unit(), unit());
      Eigen::JacobiSVD<Eigen::MatrixXd> svd(q.A, Eigen::ComputeThinU | Eigen::ComputeThinV);
      svd.setThreshold(1e-9);
      if (svd.rank() > 0 && svd.singularValues()[svd.rank() - 1] < 1e-2 * svd.singularValues()[0]) continue;
      const Vec3 expected = near - svd.solve(q.A * near + q.b);
      CHECK((minimum(q, near) - expected).norm() < 1e-6);
    }
  }

  TEST_CASE("pulled back through a map it says of a point what it says of its image") {
    const Affine T = compose(random_palette(1, 5, 3, 2)[0], 2 * identity());
    const Quadric q =
        plane_quadric(Vec3(1, 2, 3), Vec3(0.6, 0, 0.8), 3) + plane_quadric(Vec3(0, 1, 0), Vec3(0, 1, 0), 1);
    for (const Vec3& x : {Vec3(0, 0, 0), Vec3(1, -2, 5)}) {
      CHECK(pulled_back(q, T)(x) == doctest::Approx(q(transform(T, x))));
    }
  }
}
