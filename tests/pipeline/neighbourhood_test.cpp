// SPDX-License-Identifier: MIT
#include "pipeline/neighbourhood.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/random.h"
#include "tests/shapes.h"

using namespace skinlod;

TEST_SUITE("neighbourhood") {
  TEST_CASE("a walk over a convex surface ends where the closest point of all is") {
    const Surface ball = sphere(4);
    const Neighbourhood n(ball);
    const PosedSurface all(ball, ball.position);
    std::mt19937 random(3);
    int checked = 0;
    for (int i = 0; i < 500; ++i) {
      CAPTURE(i);
      const Vec3 x = random_vector(random, 2);
      if (x.norm() < 1.05) continue;  // from inside the way round may lead away
      const Place found = n.closest(ball.position, x, int(random() % unsigned(ball.face_count())));
      CHECK((n.at(ball.position, found) - x).norm() == doctest::Approx(std::sqrt(all.closest(x).squared)));
      ++checked;
    }
    CHECK(checked > 300);
  }
}
