// SPDX-License-Identifier: MIT
#include "pipeline/importance.h"

#include <doctest/doctest.h>

#include <cmath>

#include "pipeline/chain.h"
#include "pipeline/error.h"
#include "pipeline/metrics/surface_quadrics.h"
#include "pipeline/pairing.h"
#include "pipeline/parallel.h"
#include "tests/region.h"
#include "tests/shapes.h"

using namespace skinlod;

namespace {

using Of = Importance::Of;
using Selections = std::vector<Importance>;

Level level_of(const Character& c, const PoseSet& poses, const Selections& importance,
               Metric metric = Metric::Articulated) {
  return build_chain(
             c, poses,
             {.targets = {{.ratio = 0.2}}, .metric = metric, .importance = importance, .source_level = false})
      .levels.front();
}

// The tube painted red from the bottom to the top, with a second part, which has no colours, above its
// middle.
Character painted_tube() {
  Character c = bending_tube(12, 8, 4);
  Surface& s = c.surface;
  const AttributeLayout painted{.normal = true, .uv_sets = 1, .colour_sets = 1};
  s.attributes = widened(s.attributes, s.layout, painted);
  s.layout = painted;
  c.materials.push_back({.name = "cloth"});
  c.parts[0].has = painted;
  c.parts.push_back({.name = "hat", .node = c.parts[0].node, .material = 1, .has = {.normal = true}});
  for (size_t w = 0; w < s.wedges.size(); ++w) {
    const double height = s.position[size_t(s.wedges[w].vertex)].y() / 4;
    s.wedges[w].part = height > 0.5;
    if (height <= 0.5) s.attributes(Eigen::Index(w), painted.colour_at(0)) = height;
  }
  return c;
}

// One whose radius goes up and down, so that there is something to lose everywhere and at rest too.
Character wavy_tube() {
  Character c = bending_tube(20, 40, 4);
  for (Vec3& x : c.surface.position)
    x = Vec3(x.x(), 0, x.z()) * (1 + 0.2 * std::sin(5 * x.y())) + Vec3(0, x.y(), 0);
  return c;
}

bool is_refused(const Character& c, const Importance& what) {
  try {
    importance(c, Selections{what});
  } catch (const Error& e) {
    return e.fault == Fault::Usage;
  }
  return false;
}

}  // namespace

TEST_SUITE("importance") {
  TEST_CASE("a vertex has the factor mixed by how much of it is selected, and factors multiply") {
    const Character c = painted_tube();
    const std::vector<double> joints = importance(c, Selections{{Of::Joints, "joint2", 5}});
    const std::vector<double> cloth = importance(c, Selections{{Of::Material, "cl*", 3}});
    const std::vector<double> red = importance(c, Selections{{Of::Colour, "r", 0.5}});
    const std::vector<double> all = importance(
        c, Selections{{Of::Joints, "joint2", 5}, {Of::Material, "cl*", 3}, {Of::Colour, "r", 0.5}});
    for (size_t v = 0; v < all.size(); ++v) {
      CAPTURE(v);
      double weight = 0;
      for (const Influence& i : c.surface.influences[v]) weight += i.joint == 2 ? i.weight : 0;
      const double height = c.surface.position[v].y() / 4;
      CHECK(joints[v] == doctest::Approx(1 + 4 * weight));
      CHECK(cloth[v] == (height > 0.5 ? 3 : 1));
      CHECK(red[v] == doctest::Approx(height > 0.5 ? 1 : 1 - height / 2));  // no colours: not white
      CHECK(all[v] == doctest::Approx(joints[v] * cloth[v] * red[v]));
    }
    CHECK(importance(c, {}).empty());
  }

  TEST_CASE("the largest of a vertex's wedges counts") {
    Character c = painted_tube();
    c.surface.wedges.push_back({0, 1});
    c.surface.attributes.conservativeResize(c.surface.attributes.rows() + 1, Eigen::NoChange);
    c.surface.attributes.bottomRows<1>() = default_attributes(c.surface.layout);
    CHECK(selected(c, {Of::Material, "cloth"})[0] == 1);
    CHECK(selected(c, {Of::Material, "skin"})[0] == 1);
    CHECK(selected(c, {Of::Colour, "r"})[0] == 0);
  }

  TEST_CASE("what selects nothing or is out of range is refused") {
    const Character c = painted_tube();
    CHECK_FALSE(is_refused(c, {Of::Joints, "joint1", 100}));
    CHECK_FALSE(is_refused(c, {Of::Joints, "joint1", 0.01}));
    CHECK(is_refused(c, {Of::Joints, "joint9", 2}));
    CHECK(is_refused(c, {Of::Joints, "body", 2}));  // a node, but no joint
    CHECK(is_refused(c, {Of::Material, "joint1", 2}));
    CHECK_FALSE(is_refused(c, {Of::Colour, "g", 2}));
    CHECK(is_refused(c, {Of::Colour, "x", 2}));
    CHECK(is_refused(c, {Of::Colour, "rg", 2}));
    CHECK(is_refused(c, {Of::Colour, "", 2}));
    CHECK(is_refused(bending_tube(12, 8, 4), {Of::Colour, "r", 2}));
    for (const double factor : {0.0, -1.0, 0.009, 101.0, std::nan("")}) {
      CAPTURE(factor);
      CHECK(is_refused(c, {Of::Joints, "joint1", factor}));
    }
  }

  TEST_CASE("errors on faces, borders, attributes and pairs count by the square of the mean factor") {
    Surface plain = sheet(4);
    for (size_t w = 0; w < plain.wedges.size(); ++w)  // a bend in the normals, for attributes to be off
      plain.attributes.row(Eigen::Index(w)).head<3>() =
          Vec3(plain.position[w].x() * plain.position[w].x(), 0, 1).normalized().transpose();
    Surface heavy = plain;
    heavy.importance.assign(heavy.position.size(), 3);
    const Mesh a(plain), b(heavy);
    const auto quadrics = surface_quadrics(a, plain.position, held_lines(a));
    const auto nine = surface_quadrics(b, heavy.position, held_lines(b));
    const Vec3 off(0.3, 0.2, 0.7);
    for (size_t v = 0; v < quadrics.size(); ++v) {
      REQUIRE(quadrics[v](off) > 0);
      CHECK(nine[v](off) == doctest::Approx(9 * quadrics[v](off)));
    }
    double most = 0;
    for (const Edge e : a.edges()) {
      CHECK(b.attribute_error(e)(off) == doctest::Approx(9 * a.attribute_error(e)(off)));
      most = std::max(most, a.attribute_error(e)(off));
    }
    CHECK(most > 0);

    heavy.importance.assign(heavy.position.size(), 1);
    heavy.importance[0] = 4;  // in a corner, which is in one face or two: their mean is 2
    const auto pairs = paired(plain, plain), some = paired(heavy, plain);
    REQUIRE(pairs.size() == some.size());
    int changed = 0;
    for (size_t i = 0; i < pairs.size(); ++i) {
      const auto corners = triangle_vertices(plain, pairs[i].original.face);
      const bool touches = std::count(corners.begin(), corners.end(), 0) > 0;
      CHECK(some[i].area == doctest::Approx((touches ? 4 : 1) * pairs[i].area));
      changed += touches;
    }
    CHECK(changed > 0);
  }

  TEST_CASE("a factor of one and the same factor everywhere change not a bit") {
    const Character c = bending_tube(12, 12, 4);
    const PoseSet poses = few_poses(c);
    for (const Metric metric :
         {Metric::Articulated, Metric::PoseIndependent, Metric::Endpoint, Metric::RestPose}) {
      CAPTURE(int(metric));
      const Level plain = level_of(c, poses, {}, metric);
      CHECK(same(plain.surface, level_of(c, poses, {{Of::Joints, "joint3", 1}}, metric).surface));
      const Level twice = level_of(c, poses, {{Of::Material, "skin", 2}}, metric);
      CHECK(same(plain.surface, twice.surface));
      CHECK(plain.unseen_clip.rms == twice.unseen_clip.rms);  // what is measured is not weighted
      CHECK_FALSE(same(plain.surface, level_of(c, poses, {{Of::Joints, "joint3", 4}}, metric).surface));
    }
  }

  TEST_CASE("with every factor the triangles of the region grow and its posed error falls") {
    const Character c = wavy_tube();
    const PoseSet poses = few_poses(c);
    Region before{.triangles = 0, .inside = 1, .outside = 0};
    for (const double factor : {0.25, 0.5, 1.0, 2.0, 4.0, 8.0}) {
      CAPTURE(factor);
      const Level level = level_of(c, poses, {{Of::Joints, "joint3", factor}});
      const Region now = region(c, level.surface, poses.unseen_clip, "joint3");
      CHECK(now.triangles > before.triangles);
      CHECK(now.inside < before.inside);
      CHECK(now.outside > before.outside);
      before = now;
    }
  }

  TEST_CASE("every metric keeps to it") {
    const Character c = wavy_tube();
    const PoseSet poses = few_poses(c);
    for (const Metric metric : {Metric::PoseIndependent, Metric::Endpoint, Metric::RestPose}) {
      CAPTURE(int(metric));
      // What knows the bind pose alone is judged by it.
      const std::span<const Pose> seen =
          metric == Metric::RestPose ? std::span(poses.examples).first(1) : std::span(poses.examples);
      const auto under = [&](double factor) {
        return region(c, level_of(c, poses, {{Of::Joints, "joint3", factor}}, metric).surface, seen,
                      "joint3");
      };
      const Region less = under(0.25), plain = under(1), more = under(4);
      CHECK(less.triangles < plain.triangles);
      CHECK(plain.triangles < more.triangles);
      CHECK(less.inside > plain.inside);
      CHECK(plain.inside > more.inside);
      CHECK(less.outside < plain.outside);
      CHECK(plain.outside < more.outside);
    }
  }

  TEST_CASE("threads do not change what importance makes") {
    const Character c = bending_tube(16, 20, 4);
    const PoseSet poses = few_poses(c);
    const Selections selections = {{Of::Joints, "joint3", 4}, {Of::Joints, "joint0", 0.5}};
    const Surface many = level_of(c, poses, selections).surface;
    const ThreadLimit one(1);
    CHECK(same(many, level_of(c, poses, selections).surface));
  }
}
