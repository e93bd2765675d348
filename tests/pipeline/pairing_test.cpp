// SPDX-License-Identifier: MIT
#include "pipeline/pairing.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

TEST_SUITE("pairing") {
  TEST_CASE("the places given on each side stand for all of its area and integrate cubics") {
    // On a flat sheet under itself every pair is a place and the place itself.
    const Surface box = grid_box({1, 2, 3}, 3);
    const auto cubic = [](const Vec3& x) { return 1 + x.x() * x.x() * x.y() + x.z() * x.z() * x.z(); };
    double area[2] = {0, 0}, integral[2] = {0, 0}, far = 0;
    const Neighbourhood n(box);
    for (const Pair& pair : paired(box, box)) {
      const Vec3 x = n.at(box.position, pair.given_on_level ? pair.level : pair.original);
      area[pair.given_on_level] += pair.area;
      integral[pair.given_on_level] += pair.area * cubic(x);
      far = std::max(far, (n.at(box.position, pair.level) - n.at(box.position, pair.original)).norm());
    }
    CHECK(area[0] == doctest::Approx(1).epsilon(1e-6));
    CHECK(area[1] == doctest::Approx(1).epsilon(1e-6));
    // The box is symmetric about its middle, so the odd terms cancel: the constant is left.
    CHECK(integral[0] == doctest::Approx(1).epsilon(1e-6));
    CHECK(integral[1] == doctest::Approx(integral[0]).epsilon(1e-6));
    CHECK(far < 1e-9);
  }

  TEST_CASE("places that look the other way have no pair") {
    Surface inside_out = sphere(2);
    for (int f = 0; f < inside_out.face_count(); ++f)
      std::swap(inside_out.corners[size_t(3 * f)], inside_out.corners[size_t(3 * f + 1)]);
    CHECK(paired(sphere(2), inside_out).empty());
    CHECK(!paired(sphere(2), sphere(2)).empty());
  }

  TEST_CASE("few faces get more places than many") {
    const Surface coarse = sphere(2), fine = sphere(4);
    int on_level = 0, on_original = 0;
    for (const Pair& pair : paired(fine, coarse)) (pair.given_on_level ? on_level : on_original)++;
    CHECK(on_level >= 11 * coarse.face_count());
    CHECK(on_original <= 3 * fine.face_count() + 2);
  }
}
