// SPDX-License-Identifier: MIT
#include "pipeline/influences.h"

#include <doctest/doctest.h>

using namespace skinlod;

TEST_SUITE("influences") {
  TEST_CASE("a blend goes over the joints of both ends in order") {
    const Influences a = {{1, 0.5}, {4, 0.5}}, b = {{0, 0.25}, {4, 0.75}};
    CHECK(blend(a, b, 0.5) == Influences{{0, 0.125}, {1, 0.25}, {4, 0.625}});
    CHECK(blend(a, b, 0) == a);
    CHECK(blend(a, b, 1) == b);
  }

  TEST_CASE("the largest are kept and scaled and ties go to the lower joint") {
    CHECK(largest({{2, 0.5}, {3, 0.25}, {5, 0.25}}, 2) == Influences{{2, 0.5 / 0.75}, {3, 0.25 / 0.75}});
    CHECK(largest({{2, 0.5}, {3, 0.5}}, 0) == Influences{{2, 0.5}, {3, 0.5}});
    CHECK(largest({{2, 0.1}, {7, 0.9}}, 1) == Influences{{7, 1.0}});
  }

  TEST_CASE("signed weights are blended and kept by their magnitude") {
    CHECK(blend({{0, 1.5}, {1, -0.5}}, {{0, 1.0}}, 0.5) == Influences{{0, 1.25}, {1, -0.25}});
    CHECK(blend({{0, 0.5}, {1, 0.5}}, {{0, 1.5}, {1, -0.5}}, 0.5) == Influences{{0, 1.0}});
    CHECK(largest({{0, 1.25}, {1, -0.5}, {2, 0.25}}, 2) == Influences{{0, 1.25 / 0.75}, {1, -0.5 / 0.75}});
  }

  TEST_CASE("signed weights that all but cancel are shifted to sum 1 not blown up") {
    CHECK(largest({{0, 3.0}, {1, -3.0}, {2, 1.0}}, 2) == Influences{{0, 3.5}, {1, -2.5}});
    CHECK(largest({{0, -2.0}, {1, 1.5}, {2, 1.5}}, 1) == Influences{{0, 1.0}});
  }
}
