// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>

#include "pipeline/metrics/articulated.h"
#include "pipeline/metrics/endpoint.h"
#include "pipeline/metrics/pose_independent.h"
#include "pipeline/metrics/rest_pose.h"
#include "pipeline/metrics/surface_quadrics.h"
#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

const Pose kAtRest{"bind", Palette(6, identity())};

std::vector<Surface> five_meshes() {
  return {tube(12, 8, 3), tube(12, 8, 3, true), sphere(3), torus(20, 10), bending_tube(12, 10, 6).surface};
}

// A tube whose every vertex follows four joints, in poses that part them.
struct Bent {
  Character c = bending_tube(12, 16, 6);
  std::vector<Pose> poses = {kAtRest};

  Bent() {
    for (size_t v = 0; v < c.surface.influences.size(); ++v) {
      const int j = int(v % 3);
      const double a = 0.1 + 0.02 * double(v % 7), b = 0.2 + 0.01 * double(v % 5);
      c.surface.influences[v] = {{j, a}, {j + 1, b}, {j + 2, 0.5 - a}, {j + 3, 0.5 - b}};
    }
    for (unsigned p = 1; p < 6; ++p) poses.push_back({"random", random_palette(6, p, 0.6, 0.2)});
  }
};

// The quadrics of the surface posed by hand, [pose][vertex].
std::vector<std::vector<Quadric>> posed_quadrics(const Mesh& mesh, const Surface& s,
                                                 std::span<const Pose> poses) {
  std::vector<std::vector<Quadric>> quadrics;
  for (const Pose& pose : poses)
    quadrics.push_back(surface_quadrics(mesh, pose_vertices(s, pose.palette), held_lines(mesh)));
  return quadrics;
}

}  // namespace

TEST_SUITE("metrics") {
  TEST_CASE("with the rest pose alone every metric is Garland and Heckbert on every edge, attributes apart") {
    for (const Surface& s : five_meshes()) {
      const Mesh mesh(s);
      const std::span<const Pose> still(&kAtRest, 1);
      const auto quadrics = surface_quadrics(mesh, s.position, held_lines(mesh));
      const RestPoseMetric rest(mesh, s.influences);
      const ArticulatedMetric articulated(mesh, s.influences, still);
      const ArticulatedMetric as_printed(mesh, s.influences, still, {.weights = WeightRule::Signed});
      const PoseIndependentMetric pose_independent(mesh, s.influences, still);
      const EndpointMetric endpoint(mesh, s.influences, still);
      REQUIRE(mesh.edges().size() > 200);
      for (const Edge e : mesh.edges()) {
        CAPTURE(e.kept);
        CAPTURE(e.removed);
        const Vec3 &u = mesh.position[e.kept], &v = mesh.position[e.removed];
        const Quadric q = quadrics[e.kept] + quadrics[e.removed];
        const auto best = rest.place(mesh, e);
        CHECK(best.cost == doctest::Approx(q(best.position)).epsilon(1e-9).scale(1e-3));
        CHECK((q.A * best.position + q.b).norm() < 1e-9 * q.A.trace());
        const auto blended = pose_independent.place(mesh, e);
        CHECK(blended.cost == doctest::Approx(best.cost).epsilon(1e-6));
        CHECK((blended.position - best.position).norm() < 1e-5);
        const Quadric with_attributes = q + mesh.attribute_error(e);
        for (const auto& placement : {articulated.place(mesh, e), as_printed.place(mesh, e)}) {
          CHECK(placement.cost ==
                doctest::Approx(with_attributes(placement.position)).epsilon(1e-6).scale(1e-3));
          CHECK((with_attributes.A * placement.position + with_attributes.b).norm() <
                1e-6 * with_attributes.A.trace());
        }
        const auto end = endpoint.place(mesh, e);
        CHECK(end.cost == doctest::Approx(std::min(q(u), q(v))).epsilon(1e-9).scale(1e-3));
        CHECK((end.position == u || end.position == v));
        CHECK(q(end.position) == doctest::Approx(end.cost).epsilon(1e-9).scale(1e-3));
      }
    }
  }

  TEST_CASE("with one rigid joint the solving metrics do what the moved still mesh does") {
    const Surface s = torus(20, 10);
    const Pose rigid{"rigid", random_palette(1, 7, 3, 2)};
    Surface moved = s;
    moved.position = pose_vertices(s, rigid.palette);
    const Mesh mesh(s), moved_mesh(moved);
    const ArticulatedMetric articulated(mesh, s.influences, {&rigid, 1});
    const PoseIndependentMetric pose_independent(mesh, s.influences, {&rigid, 1});
    const RestPoseMetric still(moved_mesh, s.influences);
    for (const Edge e : mesh.edges()) {
      const auto there = still.place(moved_mesh, e);
      for (const auto& here : {articulated.place(mesh, e), pose_independent.place(mesh, e)}) {
        CHECK(here.cost == doctest::Approx(there.cost).epsilon(1e-5));
        CHECK((transform(rigid.palette[0], here.position) - there.position).norm() < 1e-4);
      }
    }
  }

  TEST_CASE("four rigid poses cost four times the rest pose at the same place") {
    const Surface s = torus(20, 10);
    std::vector<Pose> poses;
    for (unsigned p = 0; p < 4; ++p) poses.push_back({"rigid", random_palette(1, p, 3, 2)});
    const Mesh mesh(s);
    const ArticulatedMetric articulated(mesh, s.influences, poses);
    const PoseIndependentMetric pose_independent(mesh, s.influences, poses);
    const RestPoseMetric rest(mesh, s.influences);
    for (const Edge e : mesh.edges()) {
      const auto b = rest.place(mesh, e);
      for (const auto& a : {articulated.place(mesh, e), pose_independent.place(mesh, e)}) {
        CHECK(a.cost == doctest::Approx(4 * b.cost).epsilon(1e-5));
        CHECK((a.position - b.position).norm() < 1e-4);
      }
      // Three places fix more of the quadric than its minimum does.
      const auto ours = pose_independent.unsolved_places(mesh, e), theirs = rest.unsolved_places(mesh, e);
      for (size_t i = 0; i < 3; ++i) {
        CHECK(ours[i].position == theirs[i].position);
        CHECK(ours[i].cost == doctest::Approx(4 * theirs[i].cost).epsilon(1e-9).scale(1e-3));
      }
    }
  }

  TEST_CASE("endpoint adds over the poses what the better end costs in each") {
    const Bent bent;
    const Mesh mesh(bent.c.surface);
    const auto quadrics = posed_quadrics(mesh, bent.c.surface, bent.poses);
    EndpointMetric endpoint(mesh, bent.c.surface.influences, bent.poses);
    for (const int cap : {0, 2}) {
      CAPTURE(cap);
      endpoint.limit_influences(mesh, cap);
      // The planes stay those of the source; the points stand where what is left of their weights puts them.
      Surface s = bent.c.surface;
      s.influences = endpoint.influences();
      std::vector<std::vector<Vec3>> posed;
      for (const Pose& pose : bent.poses) posed.push_back(pose_vertices(s, pose.palette));
      int removed = 0;
      for (const Edge e : mesh.edges()) {
        std::array<double, 2> cost = {0, 0};
        for (size_t p = 0; p < posed.size(); ++p) {
          const Quadric q = quadrics[p][e.kept] + quadrics[p][e.removed];
          cost[0] += q(posed[p][e.kept]), cost[1] += q(posed[p][e.removed]);
        }
        const int end = cost[1] < cost[0] ? e.removed : e.kept;
        removed += end == e.removed;
        const auto placement = endpoint.place(mesh, e);
        CHECK(placement.cost == doctest::Approx(std::min(cost[0], cost[1])).epsilon(1e-9));
        CHECK(placement.position == s.position[end]);
        CHECK(placement.influences == s.influences[end]);
      }
      CHECK(removed > 50);
    }
  }

  TEST_CASE("endpoint never moves a vertex nor changes its influences") {
    const Bent bent;
    const Surface& s = bent.c.surface;
    Mesh mesh(s);
    EndpointMetric endpoint(mesh, s.influences, bent.poses);
    const History history = collapse(mesh, endpoint, 100);
    REQUIRE(history.size() > 100);
    for (const Step& step : history) {
      const auto v = std::find(s.position.begin(), s.position.end(), step.position) - s.position.begin();
      REQUIRE(v < int(s.position.size()));
      CHECK(step.influences == s.influences[v]);
    }
  }

  TEST_CASE("pose_independent sees every posed quadric through its own vertex's transform") {
    const Bent bent;
    const Surface& s = bent.c.surface;
    const Mesh mesh(s);
    const auto quadrics = posed_quadrics(mesh, s, bent.poses);
    const PoseIndependentMetric metric(mesh, s.influences, bent.poses);
    for (const Edge e : mesh.edges()) {
      for (const auto& placement : metric.unsolved_places(mesh, e)) {
        double cost = 0;
        for (size_t p = 0; p < bent.poses.size(); ++p) {
          for (const int v : {e.kept, e.removed})
            cost +=
                quadrics[p][v](transform(blend(s.influences[v], bent.poses[p].palette), placement.position));
        }
        CHECK(placement.cost == doctest::Approx(cost).epsilon(1e-9));
      }
      const auto solved = metric.place(mesh, e);
      for (const auto& placement : metric.unsolved_places(mesh, e)) CHECK(solved.cost <= placement.cost);
    }
  }

  // Each step of the solve costs no more with more freedom (skinned_quadric_test). The alternation of both is
  // no convex problem and stops after a few rounds, so an edge may end a little dearer.
  TEST_CASE("signed weights or no cap make collapses cheaper") {
    const Bent bent;
    const Surface& s = bent.c.surface;
    const Mesh mesh(s);
    const ArticulatedMetric usual(mesh, s.influences, bent.poses);
    const ArticulatedMetric as_printed(mesh, s.influences, bent.poses, {.weights = WeightRule::Signed});
    ArticulatedMetric capped = usual;
    capped.limit_influences(mesh, 4);  // changes no vertex, only what a collapse may give
    double sum_usual = 0, sum_signed = 0, sum_capped = 0;
    int negative = 0;
    for (const Edge e : mesh.edges()) {
      CAPTURE(e.kept);
      CAPTURE(e.removed);
      const auto placement = usual.place(mesh, e), free = as_printed.place(mesh, e),
                 narrow = capped.place(mesh, e);
      CHECK(free.cost <= 1.12 * placement.cost);
      CHECK(placement.cost <= 1.12 * narrow.cost);
      CHECK(narrow.influences.size() <= 4);
      sum_usual += placement.cost, sum_signed += free.cost, sum_capped += narrow.cost;
      double sum = 0;
      for (const auto& [joint, weight] : free.influences) sum += weight, negative += weight < 0;
      CHECK(sum == doctest::Approx(1).epsilon(1e-9));
    }
    CHECK(sum_signed < sum_usual);
    CHECK(sum_usual < 0.95 * sum_capped);
    CHECK(negative > 50);
  }

  TEST_CASE("a quadric of the surface vanishes at the vertex itself") {
    const Surface s = bending_tube(12, 10, 6).surface;
    const Mesh mesh(s);
    const auto q = surface_quadrics(mesh, s.position, held_lines(mesh));
    for (size_t v = 0; v < q.size(); ++v) CHECK(std::abs(q[v](s.position[v])) < 1e-12);
  }

  TEST_CASE("border planes hold the border where faces alone would let it slide") {
    const Surface s = tube(12, 8, 3);
    const Mesh mesh(s);
    const Vec3 off = s.position[0] - Vec3(0, 0.1, 0);
    const Quadric with = surface_quadrics(mesh, s.position, held_lines(mesh))[0];
    const Quadric without = surface_quadrics(mesh, s.position, held_lines(mesh, {.border = 0, .seam = 0}))[0];
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
    placement = {0, mesh.position[40], {{3, 1.0}}};
    CHECK_FALSE(rest.turns_a_face(mesh, e, placement));
    const Influences& own = c.surface.influences[40];
    const auto check = [&](const auto& posed) {
      CHECK(posed.turns_a_face(mesh, e, placement));
      CHECK_FALSE(posed.turns_a_face(mesh, e, {0, mesh.position[40], own}));
    };
    check(ArticulatedMetric(mesh, c.surface.influences, poses));
    check(PoseIndependentMetric(mesh, c.surface.influences, poses));
    check(EndpointMetric(mesh, c.surface.influences, poses));
  }
}
