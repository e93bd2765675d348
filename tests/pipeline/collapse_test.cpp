// SPDX-License-Identifier: MIT
#include "pipeline/collapse.h"

#include <doctest/doctest.h>

#include "pipeline/evaluate.h"
#include "pipeline/metrics/articulated.h"
#include "pipeline/metrics/endpoint.h"
#include "pipeline/metrics/pose_independent.h"
#include "pipeline/metrics/rest_pose.h"
#include "pipeline/parallel.h"
#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

Pose still(int joints) { return {"bind", Palette(size_t(joints), identity())}; }

std::vector<Pose> moving(int joints, int count) {
  std::vector<Pose> poses = {still(joints)};
  for (int p = 1; p < count; ++p) poses.push_back({"random", random_palette(joints, unsigned(p), 0.5)});
  return poses;
}

double distance(const Surface& a, const Surface& b, int joints) {
  const Pose pose = still(joints);
  const Surface* other[] = {&b};
  return spread(deviations(a, other, {&pose, 1}).front().front().distance).max;
}

bool same(const History& a, const History& b) {
  const auto equal = [](const Step& s, const Step& t) {
    return s.edge == t.edge && s.cost == t.cost && s.position == t.position && s.influences == t.influences;
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), equal);
}

}  // namespace

TEST_SUITE("collapse") {
  TEST_CASE("a finely gridded box comes back as the plain box") {
    const Vec3 size(1, 2, 3);
    const Surface source = grid_box(size, 8);
    Mesh mesh(source);
    RestPoseMetric metric(mesh, source.influences);
    collapse(mesh, metric, 12);
    const Surface box = mesh.surface(metric.influences());
    CHECK(triangle_count(box) == 12);
    CHECK(volume(box) == doctest::Approx(size.prod()).epsilon(1e-9));
    CHECK(distance(source, box, 1) < 1e-9);
  }

  TEST_CASE("a finely ringed cylinder comes back with two rings") {
    const Surface source = tube(16, 20, 5, true);
    Mesh mesh(source);
    RestPoseMetric metric(mesh, source.influences);
    collapse(mesh, metric, 16 * 2 + 2 * 14);
    const Surface plain = mesh.surface(metric.influences());
    CHECK(volume(plain) == doctest::Approx(volume(source)).epsilon(1e-7));
    CHECK(distance(source, plain, 1) < 1e-6);
  }

  TEST_CASE("closed surfaces of genus 0 end as a tetrahedron") {
    for (const Surface& source : {sphere(3), grid_box(Vec3(1, 1, 1), 5), tube(12, 5, 3, true)}) {
      Mesh mesh(source);
      RestPoseMetric metric(mesh, source.influences);
      collapse(mesh, metric, 0);
      CHECK(mesh.triangle_count() == 4);
      CHECK(volume(mesh.surface(metric.influences())) > 0);
    }
  }

  TEST_CASE("charts stretch before the shape is given up and materials never do") {
    // A ball whose upper half is cut into facets: charts of texture, or materials.
    const Surface ball = sphere(3);
    const auto error = [&](bool materials) {
      Surface s = ball;
      s.layout = {}, s.layout.uv_sets = 1;
      s.wedges.clear();
      std::vector<Vec2> uvs;
      std::vector<int> below(ball.position.size(), -1);
      for (int f = 0; f < ball.face_count(); ++f) {
        const auto vertices = triangle_vertices(ball, f);
        const auto height = [&](int v) { return ball.position[v].y(); };
        const bool above = height(vertices[0]) + height(vertices[1]) + height(vertices[2]) > 0;
        for (size_t i = 0; i < 3; ++i) {
          const int v = vertices[i];
          if (above || below[v] < 0) {
            if (!above) below[v] = int(uvs.size());
            s.corners[3 * size_t(f) + i] = int(uvs.size());
            s.wedges.push_back({v, above && materials ? f + 1 : 0});
            uvs.emplace_back(ball.position[v].x() + (above ? 3 * (f + 1) : 0), ball.position[v].z());
          } else {
            s.corners[3 * size_t(f) + i] = below[v];
          }
        }
      }
      s.attributes.resize(Eigen::Index(uvs.size()), 2);
      for (size_t w = 0; w < uvs.size(); ++w) s.attributes.row(Eigen::Index(w)) = uvs[w].transpose();
      Mesh mesh(s);
      RestPoseMetric metric(mesh, s.influences);
      const int target = s.face_count() * 3 / 10;
      collapse(mesh, metric, target);
      CHECK((mesh.triangle_count() <= target) == !materials);
      return distance(s, mesh.surface(metric.influences()), 1);
    };
    CHECK(error(true) > 2 * error(false));
  }

  TEST_CASE("genus and border loops and most of the volume are kept") {
    const Surface ring = torus(48, 16);
    Mesh mesh(ring);
    RestPoseMetric metric(mesh, ring.influences);
    collapse(mesh, metric, 200);
    const Surface coarse = mesh.surface(metric.influences());
    CHECK(mesh.triangle_count() == 200);
    CHECK(euler_characteristic(coarse) == 0);
    CHECK(volume(coarse) == doctest::Approx(volume(ring)).epsilon(0.05));

    const Surface open = tube(20, 20, 4);
    Mesh wall(open);
    RestPoseMetric wall_metric(wall, open.influences);
    collapse(wall, wall_metric, 60);
    CHECK(border_loops(wall.surface(wall_metric.influences())) == 2);
    CHECK(euler_characteristic(wall.surface(wall_metric.influences())) == 0);
  }

  TEST_CASE("weights are non-negative with sum 1 and at most N influences at every step") {
    const Character c = bending_tube(16, 24, 6);
    const auto poses = moving(6, 5);
    for (const int cap : {1, 2, 3, 4}) {
      CAPTURE(cap);
      Mesh mesh(c.surface);
      ArticulatedMetric metric(mesh, c.surface.influences, poses);
      History history = metric.limit_influences(mesh, cap);
      const History collapses = collapse(mesh, metric, 60);
      history.insert(history.end(), collapses.begin(), collapses.end());
      REQUIRE(collapses.size() > 300);
      for (const Step& step : history) {
        double sum = 0;
        for (const auto& [joint, weight] : step.influences) {
          CHECK(weight > 0);
          sum += weight;
        }
        CHECK(int(step.influences.size()) <= cap);
        CHECK(sum == doctest::Approx(1).epsilon(1e-12));
      }
    }
  }

  TEST_CASE("no collapse turns a face over in any example pose") {
    const Character c = bending_tube(16, 24, 6);
    const auto poses = moving(6, 5);
    const Mesh source(c.surface);
    const auto check_from = [&](auto metric, int cap) {
      CAPTURE(cap);
      Mesh mesh = source;
      History history = metric.limit_influences(mesh, cap);
      const History collapses = collapse(mesh, metric, 80);
      history.insert(history.end(), collapses.begin(), collapses.end());
      const TurnedFaces found = turned_faces(c.surface, history, poses);
      CHECK(found.turned == 0);
      CHECK(found.seen > 10000);
      // The count is not blind: with its points pulled far off the same history turns many.
      History wild = history;
      for (Step& step : wild) step.position *= 1.5;
      CHECK(turned_faces(c.surface, wild, poses).turned > 100);
    };
    const auto check = [&](const auto& metric) {
      for (const int cap : {0, 1}) check_from(metric, cap);
    };
    check(ArticulatedMetric(source, c.surface.influences, poses));
    check(PoseIndependentMetric(source, c.surface.influences, poses));
    check(EndpointMetric(source, c.surface.influences, poses));
  }

  TEST_CASE("one thread and two and a second run give the same history") {
    const Character c = bending_tube(24, 40, 6);
    const auto poses = moving(6, 4);
    const Mesh source(c.surface);
    const auto check = [&](const auto& make) {
      const auto run = [&](int threads) {
        const ThreadLimit limit(threads);
        Mesh mesh = source;
        auto metric = make();
        return collapse(mesh, metric, 200);
      };
      const History one = run(1);
      CHECK(one.size() > 500);
      CHECK(same(one, run(2)));
      CHECK(same(one, run(1)));
    };
    check([&] { return ArticulatedMetric(source, c.surface.influences, poses); });
    check([&] {
      return ArticulatedMetric(source, c.surface.influences, poses, {.weights = WeightRule::Signed});
    });
    check([&] { return PoseIndependentMetric(source, c.surface.influences, poses); });
    check([&] { return EndpointMetric(source, c.surface.influences, poses); });
    check([&] { return RestPoseMetric(source, c.surface.influences); });
  }

  TEST_CASE("reordering the poses changes costs by rounding alone") {
    const Character c = bending_tube(12, 12, 4);
    auto poses = moving(4, 5);
    const Mesh mesh(c.surface);
    const ArticulatedMetric one(mesh, c.surface.influences, poses);
    std::reverse(poses.begin(), poses.end());
    const ArticulatedMetric other(mesh, c.surface.influences, poses);
    for (const Edge e : mesh.edges()) {
      const auto a = one.place(mesh, e), b = other.place(mesh, e);
      CHECK(a.cost == doctest::Approx(b.cost).epsilon(1e-6));
      CHECK((a.position - b.position).norm() < 1e-5);
    }
  }

  TEST_CASE("a rigid motion of the character moves every placement along") {
    const Character c = bending_tube(12, 12, 4);
    const auto poses = moving(4, 5);
    const Affine M = random_palette(1, 99, 2, 5)[0];
    Surface moved = c.surface;
    for (Vec3& x : moved.position) x = transform(M, x);
    for (Eigen::Index w = 0; w < moved.attributes.rows(); ++w) {
      auto normal = moved.attributes.row(w).segment<3>(moved.layout.normal_at());
      normal = (M.leftCols<3>() * normal.transpose()).transpose().eval();
    }
    auto moved_poses = poses;
    for (Pose& pose : moved_poses) {
      for (Affine& T : pose.palette) T = compose(M, compose(T, inverse(M)));
    }
    const Mesh mesh(c.surface), moved_mesh(moved);
    const ArticulatedMetric a(mesh, c.surface.influences, poses),
        b(moved_mesh, moved.influences, moved_poses);
    for (const Edge e : mesh.edges()) {
      const auto here = a.place(mesh, e), there = b.place(moved_mesh, e);
      CHECK(there.cost == doctest::Approx(here.cost).epsilon(1e-5));
      CHECK((transform(M, here.position) - there.position).norm() < 1e-4);
    }
  }

  TEST_CASE("scaling the model scales the cost by the fourth power") {
    const Character c = bending_tube(12, 12, 4);
    const auto poses = moving(4, 5);
    Surface large = c.surface;
    for (Vec3& x : large.position) x *= 100;
    auto large_poses = poses;
    for (Pose& pose : large_poses) {
      for (Affine& T : pose.palette) T.col(3) *= 100;
    }
    const Mesh mesh(c.surface), large_mesh(large);
    const ArticulatedMetric a(mesh, c.surface.influences, poses),
        b(large_mesh, large.influences, large_poses);
    for (const Edge e : mesh.edges()) {
      const double cost = a.place(mesh, e).cost;
      CHECK(b.place(large_mesh, e).cost == doctest::Approx(cost * 1e8).epsilon(1e-6).scale(1e4));
    }
  }
}
