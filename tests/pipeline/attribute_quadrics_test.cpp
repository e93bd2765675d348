// SPDX-License-Identifier: MIT
#include "pipeline/attribute_quadrics.h"

#include <doctest/doctest.h>

#include <array>

#include "pipeline/chain.h"
#include "pipeline/mesh.h"
#include "tests/random.h"
#include "tests/shapes.h"

using namespace skinlod;
using Unit = AttributeQuadrics::Unit;

namespace {

struct Patch {
  Mat3 x;
  Rows attributes;
  double area() const { return (x.col(1) - x.col(0)).cross(x.col(2) - x.col(0)).norm() / 2; }
};

// Triangles that are no slivers, with two columns of any attributes.
std::vector<Patch> any_patches(std::mt19937& random, int count) {
  std::vector<Patch> patches;
  while (int(patches.size()) < count) {
    Patch p{Mat3(), Rows(3, 2)};
    for (int k = 0; k < 3; ++k) {
      p.x.col(k) = random_vector(random, 1);
      p.attributes.row(k) << uniform(random, -1, 1), uniform(random, -1, 1);
    }
    const double longest = (p.x.colwise() - p.x.rowwise().mean()).colwise().squaredNorm().maxCoeff();
    if (p.area() > 0.5 * longest) patches.push_back(p);
  }
  return patches;
}

// The same, worked out another way: at x each face says its own value, and the best is their mean.
double error_by_hand(const std::vector<Patch>& patches, const Vec3& x) {
  double total = 0, error = 0;
  for (const Patch& p : patches) total += p.area();
  for (int c = 0; c < 2; ++c) {
    std::vector<double> said;
    double mean = 0;
    for (const Patch& p : patches) {
      const Vec3 u = p.x.col(1) - p.x.col(0), v = p.x.col(2) - p.x.col(0);
      Mat3 M;
      M << u.transpose(), v.transpose(), u.cross(v).transpose();
      const auto a = p.attributes.col(c);
      const Vec3 g = M.fullPivLu().solve(Vec3(a[1] - a[0], a[2] - a[0], 0));
      said.push_back(a[0] + g.dot(x - p.x.col(0)));
      mean += p.area() * said.back() / total;
    }
    for (size_t i = 0; i < said.size(); ++i) error += patches[i].area() * (said[i] - mean) * (said[i] - mean);
  }
  return error;
}

// The RMS error in v of what is left of a tube whose v is the square of the height, at a twentieth of its
// triangles, in the bind pose alone and without fitting.
double texture_error(Metric metric) {
  Character c = bending_tube(24, 32, 4);
  Surface& s = c.surface;
  for (size_t w = 0; w < s.wedges.size(); ++w) {
    const double y = s.position[s.wedges[w].vertex].y();
    s.attributes(Eigen::Index(w), s.layout.uv_at(0) + 1) = y * y;
  }
  const PoseSet poses = choose_poses(c, {.from_clips = 0, .range_of_motion = 0});
  REQUIRE(poses.examples.size() == 1);
  const Chain chain = build_chain(c, poses,
                                  {.targets = {{.ratio = 0.05}},
                                   .metric = metric,
                                   .source_level = false,
                                   .refine = 0,
                                   .measured = false});
  const Surface* level[] = {&chain.levels[0].surface};
  const auto found = deviations(triangulated(s), level, poses.examples, {.attributes = true, .bound = false});
  return spread(found[0][0].uv).rms;
}

}  // namespace

TEST_SUITE("attribute_quadrics") {
  TEST_CASE("the error is that of the mean of what the faces say") {
    std::mt19937 random(5);
    for (int trial = 0; trial < 20; ++trial) {
      CAPTURE(trial);
      const std::vector<Patch> patches = any_patches(random, 6);
      AttributeQuadrics metres(6, 2, Unit::Metre), sizes(6, 2, Unit::PatchSize);
      double area = 0;
      for (int i = 0; i < 6; ++i) {
        const std::array<int, 1> group = {i};
        metres.add_face(patches[size_t(i)].x, patches[size_t(i)].attributes, group);
        sizes.add_face(patches[size_t(i)].x, patches[size_t(i)].attributes, group);
        area += patches[size_t(i)].area();
      }
      const std::array<int, 6> all = {0, 1, 2, 3, 4, 5};
      const Vec3 x = random_vector(random, 1);
      const double apart = metres.error(all)(x);
      CHECK(apart == doctest::Approx(error_by_hand(patches, x)).epsilon(5e-3));
      CHECK(sizes.error(all)(x) == doctest::Approx(area * apart));
      for (int i = 1; i < 6; ++i) metres.merge(0, i);
      CHECK(metres.error(std::array{0})(x) == doctest::Approx(apart));
    }
  }

  TEST_CASE("what is linear on a plane may be gathered anywhere on it, and a bend may not") {
    AttributeQuadrics straight(4, 1, Unit::Metre), bent(4, 1, Unit::Metre);
    for (int i = 0; i < 4; ++i) {
      Mat3 x;
      x << i, i + 1, i, 0, 0, 1, 2, 2, 2;
      const std::array<int, 1> group = {i};
      Rows linear(3, 1), square(3, 1);
      for (int k = 0; k < 3; ++k) linear(k, 0) = 3 * x(0, k) - x(1, k) + 5, square(k, 0) = x(0, k) * x(0, k);
      straight.add_face(x, linear, group), bent.add_face(x, square, group);
    }
    const std::array<int, 4> all = {0, 1, 2, 3};
    for (const Vec3& x : {Vec3(0, 0, 2), Vec3(1.5, 0.3, 2), Vec3(9, -4, 2)}) {
      CHECK(straight.error(all)(x) < 1e-5);
      CHECK(bent.error(all)(x) > 1);
    }
  }

  TEST_CASE("a sliver says nothing that is out of all proportion") {
    AttributeQuadrics quadrics(1, 1, Unit::Metre);
    Mat3 x;
    x << 0, 1, 0.5, 0, 0, 1e-9, 0, 0, 0;
    Rows jump(3, 1);
    jump << 0, 0, 1;
    quadrics.add_face(x, jump, std::array{0});
    const Quadric q = quadrics.error(std::array{0});
    CHECK(q.A.allFinite());
    CHECK(q.A.norm() < 1e-3);
  }

  TEST_CASE("a surface twice as large has sixteen times the error, in both units") {
    Character c = bending_tube(8, 8, 4);
    const Mesh mesh(c.surface);
    for (Vec3& x : c.surface.position) x *= 2;
    const Mesh large(c.surface);
    double most = 0;
    for (const Edge e : mesh.edges()) {
      const Vec3 x = (mesh.position[e.kept] + mesh.position[e.removed]) / 2;
      const double error = mesh.attribute_error(e)(x);
      CHECK(large.attribute_error(e)(2 * x) == doctest::Approx(16 * error).epsilon(1e-6));
      most = std::max(most, error);
    }
    CHECK(most > 0);
  }

  TEST_CASE("texture coordinates that bend on a straight surface are kept by a metric that looks at them") {
    const double looking = texture_error(Metric::Articulated), blind = texture_error(Metric::RestPose);
    CAPTURE(looking);
    CAPTURE(blind);
    CHECK(looking < 0.5 * blind);
  }
}
