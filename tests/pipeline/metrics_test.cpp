// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "pipeline/metrics/articulated.h"
#include "pipeline/metrics/rest_pose.h"
#include "pipeline/metrics/surface_quadrics.h"
#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

TEST_SUITE("metrics") {
  TEST_CASE("with the rest pose alone articulated is Garland and Heckbert") {
    const Pose still{"bind", Palette(6, identity())};
    for (const Surface& s :
         {tube(12, 8, 3), tube(12, 8, 3, true), sphere(3), torus(20, 10), bending_tube(12, 10, 6).surface}) {
      const Mesh mesh(s);
      const ArticulatedMetric articulated(mesh, s.influences, {&still, 1});
      const RestPoseMetric rest(mesh, s.influences);
      for (const Edge e : mesh.edges()) {
        CAPTURE(e.kept);
        CAPTURE(e.removed);
        const auto a = articulated.place(mesh, e);
        const auto b = rest.place(mesh, e);
        CHECK(a.cost == doctest::Approx(b.cost).epsilon(1e-6));
        CHECK((a.position - b.position).norm() < 1e-5);
      }
    }
  }

  TEST_CASE("with one rigid joint articulated places points where the still mesh does") {
    const Surface s = torus(20, 10);
    std::vector<Pose> poses;
    for (unsigned p = 0; p < 4; ++p) poses.push_back({"rigid", random_palette(1, p, 3, 2)});
    const Mesh mesh(s);
    const ArticulatedMetric articulated(mesh, s.influences, poses);
    const RestPoseMetric rest(mesh, s.influences);
    for (const Edge e : mesh.edges()) {
      const auto a = articulated.place(mesh, e);
      const auto b = rest.place(mesh, e);
      CHECK(a.cost == doctest::Approx(4 * b.cost).epsilon(1e-5));
      CHECK((a.position - b.position).norm() < 1e-4);
    }
  }

  TEST_CASE("a quadric of the surface vanishes at the vertex itself") {
    const Surface s = bending_tube(12, 10, 6).surface;
    const Mesh mesh(s);
    const auto q = surface_quadrics(mesh, s.position);
    for (size_t v = 0; v < q.size(); ++v) CHECK(std::abs(q[v](s.position[v])) < 1e-12);
  }

  TEST_CASE("border planes hold the border where faces alone would let it slide") {
    const Surface s = tube(12, 8, 3);
    const Mesh mesh(s);
    const Vec3 off = s.position[0] - Vec3(0, 0.1, 0);
    const Quadric with = surface_quadrics(mesh, s.position)[0];
    const Quadric without = surface_quadrics(mesh, s.position, {.border = 0, .seam = 0})[0];
    const double edge = (s.position[0] - s.position[1]).squaredNorm();
    CHECK(with(off) - without(off) == doctest::Approx(2 * edge * 0.01).epsilon(1e-6));
  }

  TEST_CASE("the cap holds and the weights kept are solved for") {
    Character c = bending_tube(16, 24, 4);
    for (Influences& i : c.surface.influences) i = {{0, 0.4}, {1, 0.3}, {2, 0.2}, {3, 0.1}};
    std::vector<Pose> poses = {{"bind", Palette(4, identity())}};
    for (unsigned p = 1; p < 6; ++p) poses.push_back({"random", random_palette(4, p, 0.6)});
    const Mesh mesh(c.surface);
    ArticulatedMetric metric(mesh, c.surface.influences, poses);
    const History changed = metric.limit_influences(mesh, 2);
    CHECK(changed.size() == c.surface.position.size());
    for (const Influences& i : metric.influences()) {
      CHECK(i.size() <= 2);
      double sum = 0;
      for (const auto& [joint, weight] : i) sum += weight;
      CHECK(sum == doctest::Approx(1).epsilon(1e-12));
    }
  }

  TEST_CASE("a face that would turn over only in a pose is seen") {
    // A flat strip of two joints: pose 1 lifts the right half, and a point dragged far right turns a face
    // there.
    Character c = bending_tube(12, 12, 4);
    const Mesh mesh(c.surface);
    std::vector<Pose> poses = {{"bind", Palette(4, identity())}};
    RestPoseMetric rest(mesh, c.surface.influences);
    const Edge e{40, 41};
    RestPoseMetric::Placement placement{0, mesh.position[40], c.surface.influences[40]};
    CHECK_FALSE(rest.turns_a_face(mesh, e, placement));
    placement.position = mesh.position[40] + Vec3(0, 3, 0);
    CHECK(rest.turns_a_face(mesh, e, placement));

    // At rest the influences do not matter; in a pose where the joints part they throw the point out of its
    // ring.
    poses.push_back({"apart", Palette(4, identity())});
    poses[1].palette[3].col(3) = Vec3(0, 8, 0);
    const ArticulatedMetric posed(mesh, c.surface.influences, poses);
    placement = {0, mesh.position[40], {{3, 1.0}}};
    CHECK_FALSE(rest.turns_a_face(mesh, e, placement));
    CHECK(posed.turns_a_face(mesh, e, placement));
  }
}
