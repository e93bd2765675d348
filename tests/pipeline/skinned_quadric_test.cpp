// SPDX-License-Identifier: MIT
#include "pipeline/metrics/skinned_quadric.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "pipeline/byte_weights.h"
#include "pipeline/metrics/skinned_point.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

struct Random {
  explicit Random(unsigned seed) : engine(seed) {}
  double unit() { return double(engine()) / double(std::mt19937::max()) * 2 - 1; }
  Vec3 vector() { return Vec3(unit(), unit(), unit()); }
  std::mt19937 engine;
};

struct Case {
  std::vector<Palette> palettes;
  std::vector<Quadric> quadrics;
  std::vector<int> joints;
  Weights start;
  Vec3 x;

  Case(unsigned seed, int K, int P) {
    Random random(seed);
    for (int p = 0; p < P; ++p) {
      palettes.push_back(random_palette(K, seed * 100 + unsigned(p), 1.5, 0.3));
      Quadric q;
      for (int i = 0; i < 6; ++i) q += plane_quadric(random.vector(), random.vector().normalized(), 1);
      quadrics.push_back(q);
    }
    start = Weights(K);
    for (int k = 0; k < K; ++k) joints.push_back(k), start[k] = 1.1 + random.unit();
    start /= start.sum();
    x = random.vector();
  }
  SkinnedQuadric problem() const { return {quadrics, palettes, joints, x}; }
};

// The weights of sum 1 over the joints `in` at which E is stationary, 0 for the others: the paper's equation
// 4, by Lagrange multipliers.
Weights stationary_weights(const Case& c, const std::vector<int>& in) {
  const int n = int(in.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n + 1, n + 1);
  Eigen::VectorXd r = Eigen::VectorXd::Zero(n + 1);
  for (size_t p = 0; p < c.quadrics.size(); ++p) {
    for (int i = 0; i < n; ++i) {
      const Vec3 yi = transform(c.palettes[p][in[i]], c.x);
      r[i] -= c.quadrics[p].b.dot(yi);
      for (int j = 0; j < n; ++j) A(i, j) += yi.dot(c.quadrics[p].A * transform(c.palettes[p][in[j]], c.x));
    }
  }
  for (int i = 0; i < n; ++i) A(i, n) = A(n, i) = 1;
  r[n] = 1;
  const Eigen::VectorXd w = A.fullPivLu().solve(r);
  Weights all = Weights::Zero(Eigen::Index(c.joints.size()));
  for (int i = 0; i < n; ++i) all[in[i]] = w[i];
  return all;
}

// The minimum over all weights >= 0 with sum 1, by trying every set of joints that may be non-zero: on each
// set the stationary point, if it is inside.
double least_by_enumeration(const Case& c) {
  const int K = int(c.joints.size());
  double least = std::numeric_limits<double>::infinity();
  for (unsigned set = 1; set < 1u << K; ++set) {
    std::vector<int> in;
    for (int k = 0; k < K; ++k) {
      if (set >> k & 1) in.push_back(k);
    }
    const Weights w = stationary_weights(c, in);
    if (w.minCoeff() >= -1e-9) least = std::min(least, c.problem()(c.x, w));
  }
  return least;
}

}  // namespace

TEST_SUITE("skinned_quadric") {
  TEST_CASE("best weights are those of trying every set of joints") {
    for (unsigned seed = 1; seed <= 60; ++seed) {
      CAPTURE(seed);
      const Case c(seed, 2 + int(seed % 5), 9);
      const SkinnedQuadric E = c.problem();
      const Weights w = E.best_weights(c.x, c.start);
      CHECK(w.minCoeff() >= 0);
      CHECK(w.sum() == doctest::Approx(1).epsilon(1e-12));
      CHECK(E(c.x, w) == doctest::Approx(least_by_enumeration(c)).epsilon(1e-6));
    }
  }

  TEST_CASE("signed weights solve the equations as they are printed") {
    int negative = 0;
    for (unsigned seed = 1; seed <= 60; ++seed) {
      CAPTURE(seed);
      const Case c(seed, 2 + int(seed % 5), 9);
      const SkinnedQuadric E = c.problem();
      const Weights w = E.best_weights(c.x, c.start, WeightRule::Signed);
      negative += w.minCoeff() < 0;
      CHECK(w.sum() == doctest::Approx(1).epsilon(1e-12));
      CHECK(E(c.x, w) == doctest::Approx(E(c.x, stationary_weights(c, c.joints))).epsilon(1e-6));
      CHECK(E(c.x, w) <= E(c.x, E.best_weights(c.x, c.start)) * (1 + 1e-9));
    }
    CHECK(negative > 20);
  }

  TEST_CASE("fewer joints never fit better from the same place") {
    for (unsigned seed = 1; seed <= 60; ++seed) {
      CAPTURE(seed);
      const int K = 3 + int(seed % 5);
      Case c(seed, K, 9);
      const std::vector<int> places = {0, K - 1};
      c.start = Weights::Zero(K);
      c.start[0] = 0.3, c.start[K - 1] = 0.7;
      const Weights start = Weights(Eigen::Vector2d(0.3, 0.7));
      for (const WeightRule rule : {WeightRule::NonNegative, WeightRule::Signed}) {
        const SkinnedQuadric E = c.problem(), some = E.over(places);
        const double all = E(c.x, E.best_weights(c.x, c.start, rule));
        CHECK(all <= some(c.x, some.best_weights(c.x, start, rule)) * (1 + 1e-9));
      }
    }
  }

  TEST_CASE("neither step raises the error, from any start") {
    for (unsigned seed = 1; seed <= 40; ++seed) {
      CAPTURE(seed);
      const Case c(seed, 1 + int(seed % 8), 1 + int(seed % 7));
      const SkinnedQuadric E = c.problem();
      Vec3 x = c.x;
      Weights w = c.start;
      double before = E(x, w);
      for (int round = 0; round < 5; ++round) {
        x = E.best_position(w, x);
        CHECK(E(x, w) <= before * (1 + 1e-9));
        before = E(x, w);
        w = E.best_weights(x, w);
        CHECK(E(x, w) <= before * (1 + 1e-9));
        before = E(x, w);
      }
    }
  }

  TEST_CASE("where joints move alike the weights stay as they were") {
    Case c(7, 4, 3);
    for (Palette& palette : c.palettes) palette.assign(4, palette[0]);
    CHECK((c.problem().best_weights(c.x, c.start) - c.start).norm() < 1e-12);
  }

  TEST_CASE("joints that move all but alike beside others that do not give weights all the same") {
    for (unsigned seed = 1; seed <= 400; ++seed) {
      CAPTURE(seed);
      Case c(seed, 6, 4);
      Random random(seed);
      const double apart = std::pow(10.0, -4 - double(seed % 12));  // 1e-4 to 1e-15
      for (Palette& palette : c.palettes) {
        for (const int k : {1, 2, 4}) {
          palette[k] = palette[0];
          palette[k].col(3) += apart * random.vector();
        }
        if (seed % 2 == 0) palette[3] = palette[1];  // no joint is far off
        palette[5] = palette[3];
      }
      if (seed > 200) {  // slivers: one plane, next to no area
        for (Quadric& q : c.quadrics) q = plane_quadric(c.x, random.vector().normalized(), 1e-8);
      }
      const SkinnedQuadric E(c.quadrics, c.palettes, c.joints, c.x + 0.1 * random.vector());
      for (const WeightRule rule : {WeightRule::NonNegative, WeightRule::Signed}) {
        const Weights w = E.best_weights(c.x, c.start, rule);
        CHECK(w.allFinite());
        CHECK(w.sum() == doctest::Approx(1).epsilon(1e-9));
        CHECK(E(c.x, w) <= E(c.x, c.start) * (1 + 1e-6) + 1e-15);
        if (rule == WeightRule::NonNegative) CHECK(w.minCoeff() >= 0);
      }
    }
  }

  TEST_CASE("joints that move in the planes alone leave the weights as they were") {
    for (unsigned seed = 1; seed <= 200; ++seed) {
      CAPTURE(seed);
      Case c(seed, 5, 6);
      Random random(seed);
      for (size_t p = 0; p < c.palettes.size(); ++p) {
        const Affine moved = random_palette(1, seed * 31 + unsigned(p), 1.5, 0.3).front();
        const Vec3 n = Vec3(moved.col(2)).normalized();
        const Vec3 across = n.cross(random.vector()).normalized(), along = n.cross(across);
        c.quadrics[p] = plane_quadric(transform(moved, c.x), n, 1e-8);
        const double slide = seed % 2 == 0 ? 0.1 : 0;
        for (Affine& T : c.palettes[p]) {
          // About a line square to the plane, through a point near c.x, and along the plane.
          const Mat3 turn = Eigen::AngleAxisd(random.unit(), n).toRotationMatrix();
          const Vec3 centre = transform(moved, c.x);
          T.leftCols<3>() = turn * moved.leftCols<3>();
          T.col(3) = turn * (moved.col(3) - centre) + centre;
          T.col(3) += slide * (random.unit() * across + random.unit() * along);
        }
      }
      const SkinnedQuadric E = c.problem();
      // Away from the middle, but in the plane of the rest pose.
      const Vec3 x = c.x + Vec3(random.unit(), random.unit(), 0);
      for (const WeightRule rule : {WeightRule::NonNegative, WeightRule::Signed}) {
        const Weights w = E.best_weights(x, c.start, rule);
        CHECK((w - c.start).norm() < 1e-6);
      }
    }
  }

  TEST_CASE("with fewer poses than joints the offset is the smallest that fits") {
    // One pose, one plane: only the component along the plane's slope may change.
    Case c(11, 3, 1);
    c.quadrics = {plane_quadric(Vec3(0, 0, 0.1), Vec3(0, 0, 1), 1)};
    c.start = Weights::Constant(3, 1.0 / 3);
    for (int k = 0; k < 3; ++k) {
      c.palettes[0][k] = identity();
      c.palettes[0][k].col(3) = Vec3(0, 0, k - 1.0);
    }
    c.x = Vec3::Zero();
    const Weights w = c.problem().best_weights(c.x, c.start);
    // w2 - w0 = 0.1 with sum 1: the closest such weights to thirds.
    CHECK(w[0] == doctest::Approx(1.0 / 3 - 0.05).epsilon(1e-4));
    CHECK(w[1] == doctest::Approx(1.0 / 3).epsilon(1e-4));
    CHECK(w[2] == doctest::Approx(1.0 / 3 + 0.05).epsilon(1e-4));
  }

  TEST_CASE("a true position is found again under its weights") {
    Case c(5, 3, 6);
    Random random(17);
    const Vec3 truth = random.vector();
    for (size_t p = 0; p < c.quadrics.size(); ++p) {
      Affine T =
          c.start[0] * c.palettes[p][0] + c.start[1] * c.palettes[p][1] + c.start[2] * c.palettes[p][2];
      c.quadrics[p] = Quadric{};
      for (int i = 0; i < 3; ++i) {
        c.quadrics[p] += plane_quadric(transform(T, truth), random.vector().normalized(), 1);
      }
    }
    CHECK((c.problem().best_position(c.start, c.x) - truth).norm() < 1e-6);
  }

  TEST_CASE("joints that are left out are those that cost least, within a little of trying every choice") {
    double ours = 0, all = 0, largest_kept = 0;
    for (unsigned seed = 1; seed <= 40; ++seed) {
      CAPTURE(seed);
      const Case c(seed, 6, 9);
      const SkinnedQuadric E = c.problem();
      const auto cost_of = [&](const std::vector<int>& places) {
        const SkinnedQuadric few = E.over(places);
        const Weights start = Weights::Constant(Eigen::Index(places.size()), 1.0 / double(places.size()));
        return few(c.x, few.best_weights(c.x, start));
      };
      double least = std::numeric_limits<double>::infinity();
      for (int a = 0; a < 6; ++a) {
        for (int b = a + 1; b < 6; ++b) least = std::min(least, cost_of({a, b}));
      }
      const SkinnedPoint start{c.x, influences_of(c.joints, c.start)};
      const Influences kept = reweighted(E, start, 2, WeightRule::NonNegative);
      CHECK(kept.size() <= 2);
      const double cost = error_at(E, {c.x, kept});
      CHECK(cost >= least * (1 - 1e-6));
      ours += cost, all += least;
      std::vector<int> places;
      for (const Influence& i : largest(reweighted(E, start, 0, WeightRule::NonNegative), 2))
        places.push_back(i.joint);
      largest_kept += cost_of(places);
    }
    CHECK(ours < 1.05 * all);
    CHECK(largest_kept > ours);
  }

  TEST_CASE("of two joints that move alike one is kept, and the third, which is smaller, with it") {
    Case c(7, 3, 9);
    for (Palette& palette : c.palettes) palette[1] = palette[0];
    c.quadrics.clear();
    c.start << 0.4, 0.35, 0.25;
    for (const Palette& palette : c.palettes) {
      const Vec3 posed = 0.75 * transform(palette[0], c.x) + 0.25 * transform(palette[2], c.x);
      Quadric q;
      for (int i = 0; i < 3; ++i) q += plane_quadric(posed, Vec3::Unit(i), 1);
      c.quadrics.push_back(q);
    }
    const SkinnedQuadric E = c.problem();
    const Influences kept =
        reweighted(E, {c.x, influences_of(c.joints, c.start)}, 2, WeightRule::NonNegative);
    REQUIRE(kept.size() == 2);
    CHECK(kept[1].joint == 2);
    CHECK(kept[1].weight == doctest::Approx(0.25).epsilon(1e-4));
    const double largest_two = error_at(E, {c.x, {{0, 0.4 / 0.75}, {1, 0.35 / 0.75}}});
    CHECK(error_at(E, {c.x, kept}) < 1e-6 * largest_two);
  }

  TEST_CASE("rounding weights costs hardly more than the best of all roundings, and less than the nearest") {
    double ours = 0, all = 0, nearest = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
      CAPTURE(seed);
      Case c(seed, 3, 9);
      c.quadrics.clear();
      Random random(seed);
      for (const Palette& palette : c.palettes) {
        Vec3 posed = Vec3::Zero();
        for (int k = 0; k < 3; ++k) posed += c.start[k] * transform(palette[size_t(k)], c.x);
        c.quadrics.push_back(plane_quadric(posed, random.vector().normalized(), 1));
      }
      const SkinnedQuadric E = c.problem();
      const auto cost_of = [&](const Weights& w) { return E(E.best_position(w, c.x), w); };
      double least = std::numeric_limits<double>::infinity();
      const int first = int(c.start[0] * 255), second = int(c.start[1] * 255);
      for (int a = std::max(0, first - 8); a <= first + 8; ++a) {
        for (int b = std::max(0, second - 8); b <= second + 8 && a + b <= 255; ++b)
          least = std::min(least, cost_of(Weights{{a / 255.0, b / 255.0, (255 - a - b) / 255.0}}));
      }
      const SkinnedPoint exact{c.x, influences_of(c.joints, c.start)};
      CHECK(error_at(E, exact) < 1e-12);
      const SkinnedPoint found = rounded(E, exact);
      CHECK(rounded(found.influences) == found.influences);
      CHECK(error_at(E, found) >= least * (1 - 1e-9));
      ours += error_at(E, found), all += least;
      nearest += error_at(E, {c.x, rounded(exact.influences)});
    }
    CAPTURE(all);
    CAPTURE(ours);
    CAPTURE(nearest);
    CHECK(ours < 1.01 * all);
    CHECK(nearest > 1.3 * ours);
  }
}
