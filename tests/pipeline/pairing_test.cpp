// SPDX-License-Identifier: MIT
#include "pipeline/pairing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

struct Box {
  Vec3 size, middle;
  Vec3 low() const { return middle - size / 2; }
  Vec3 high() const { return middle + size / 2; }
};

using Powers = std::array<int, 3>;

double monomial(const Vec3& x, const Powers& powers) {
  double product = 1;
  for (int i = 0; i < 3; ++i) product *= std::pow(x[i], powers[size_t(i)]);
  return product;
}

// The mean of a monomial over the six sides: of each the product of the means along its two axes.
double mean_over(const Box& box, const Powers& powers) {
  double sum = 0, area = 0;
  for (int across = 0; across < 3; ++across) {
    double means = 1, its = 1;
    for (int i = 0; i < 3; ++i) {
      const int k = powers[size_t(i)];
      if (i == across) {
        means *= (std::pow(box.low()[i], k) + std::pow(box.high()[i], k)) / 2;
      } else {
        means *= (std::pow(box.high()[i], k + 1) - std::pow(box.low()[i], k + 1)) / ((k + 1) * box.size[i]);
        its *= box.size[i];
      }
    }
    sum += its * means, area += its;
  }
  return sum / area;
}

// A surface under itself: every pair is a place and the place itself. Pairs hold their areas as floats.
void check_places(const Box& box, int cuts, const Powers& powers, double least_to_a_face, double most) {
  Surface s = grid_box(box.size, cuts);
  for (Vec3& x : s.position) x += box.middle;
  const Neighbourhood n(s);
  double area[2] = {0, 0}, integral[2] = {0, 0}, far = 0;
  int count = 0;
  for (const Pair& pair : paired(s, s)) {
    const Vec3 x = n.at(s.position, pair.given_on_level ? pair.level : pair.original);
    area[pair.given_on_level] += pair.area;
    integral[pair.given_on_level] += pair.area * monomial(x, powers);
    far = std::max(far, (n.at(s.position, pair.level) - n.at(s.position, pair.original)).norm());
    count += pair.given_on_level;
  }
  CHECK(far < 1e-9);
  CHECK(count >= least_to_a_face * s.face_count());
  CHECK(count <= most * s.face_count());
  for (const int side : {0, 1}) {
    CHECK(area[side] == doctest::Approx(1).epsilon(1e-6));
    CHECK(integral[side] == doctest::Approx(mean_over(box, powers)).epsilon(1e-6));
  }
}

}  // namespace

TEST_SUITE("pairing") {
  TEST_CASE("the places given on each side stand for all of its area and integrate cubics") {
    const Box box{{1, 2, 3}, {0.25, -0.5, 0.75}};
    check_places(box, 3, {3, 0, 0}, 11, 13);
    check_places(box, 3, {2, 1, 0}, 11, 13);
    check_places(box, 3, {0, 1, 2}, 11, 13);
  }

  TEST_CASE("there are fewer on a large surface, and they integrate quadratics") {
    const Box box{{1, 2, 3}, {0.25, -0.5, 0.75}};
    check_places(box, 118, {2, 0, 0}, 1.4, 1.6);
    check_places(box, 118, {0, 1, 1}, 1.4, 1.6);
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
