// SPDX-License-Identifier: MIT
#include "tests/shapes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "tests/topology.h"

using namespace skinlod;

namespace {

using std::numbers::pi;

int vertex(const Surface& s, int corner) { return s.wedges[size_t(corner)].vertex; }

struct Topology {
  int euler;         // vertices - edges + faces
  int border_edges;  // edges with one face
  bool manifold;     // no directed edge twice: at most two faces at an edge, and those agree about their side
};

Topology topology(const Surface& s) {
  std::set<std::pair<int, int>> directed, edges;
  std::set<int> used;
  Topology t{0, 0, true};
  for (int f = 0; f < s.face_count(); ++f) {
    const auto c = s.face(f);
    for (size_t i = 0; i < c.size(); ++i) {
      const int a = vertex(s, c[i]), b = vertex(s, c[(i + 1) % c.size()]);
      t.manifold &= a != b && directed.insert({a, b}).second;
      edges.insert({std::min(a, b), std::max(a, b)});
      used.insert(a);
    }
  }
  for (const auto& [a, b] : directed) t.border_edges += !directed.contains({b, a});
  t.euler = int(used.size()) - int(edges.size()) + s.face_count();
  CHECK(used.size() == s.position.size());
  return t;
}

void check_closed(const Surface& s, int euler) {
  const Topology t = topology(s);
  CHECK(t.manifold);
  CHECK(t.border_edges == 0);
  CHECK(t.euler == euler);
  CHECK(volume(s) > 0);
}

void check_tables(const Surface& s) {
  CHECK(s.influences.size() == s.position.size());
  CHECK(s.attributes.rows() == Eigen::Index(s.wedges.size()));
  CHECK(s.attributes.cols() == s.layout.columns());
  for (const Influences& influences : s.influences) {
    double sum = 0;
    int last = -1;
    for (const auto& [joint, weight] : influences) {
      CHECK(joint > last);
      CHECK(weight > 0);
      last = joint, sum += weight;
    }
    CHECK(sum == doctest::Approx(1).epsilon(1e-14));
  }
}

}  // namespace

TEST_SUITE("shapes") {
  TEST_CASE("a gridded box is closed and has the volume and area of its size") {
    for (const int n : {1, 2, 7}) {
      const Surface s = grid_box(Vec3(1, 2, 3), n);
      CAPTURE(n);
      check_closed(s, 2);
      check_tables(s);
      CHECK(s.face_count() == 12 * n * n);
      CHECK(volume(s) == doctest::Approx(6).epsilon(1e-12));
      CHECK(area(s) == doctest::Approx(22).epsilon(1e-12));
    }
  }

  TEST_CASE("a tube is a wall with two border loops and a closed one has caps") {
    const int around = 24, rings = 10;
    const double length = 5;
    const Surface open = tube(around, rings, length);
    const Topology t = topology(open);
    CHECK(t.manifold);
    CHECK(t.border_edges == 2 * around);
    CHECK(t.euler == 0);
    const double wall = length * around * 2 * std::sin(pi / around);
    CHECK(area(open) == doctest::Approx(wall).epsilon(1e-12));
    check_tables(open);

    const Surface closed = tube(around, rings, length, true);
    const double end = around * std::sin(2 * pi / around) / 2;
    check_closed(closed, 2);
    CHECK(volume(closed) == doctest::Approx(end * length).epsilon(1e-12));
    CHECK(area(closed) == doctest::Approx(wall + 2 * end).epsilon(1e-12));
  }

  TEST_CASE("a sphere is closed and tends to the volume of the ball") {
    for (int level = 0; level <= 4; ++level) {
      const Surface s = sphere(level);
      CAPTURE(level);
      check_closed(s, 2);
      CHECK(s.face_count() == 8 << (2 * level));
      for (const Vec3& x : s.position) CHECK(x.norm() == doctest::Approx(1).epsilon(1e-14));
    }
    CHECK(volume(sphere(0)) == doctest::Approx(4.0 / 3).epsilon(1e-14));
    CHECK(volume(sphere(5)) == doctest::Approx(4 * pi / 3).epsilon(2e-3));
  }

  TEST_CASE("a torus is closed with genus 1") {
    const Surface s = torus(64, 32);
    check_closed(s, 0);
    CHECK(volume(s) == doctest::Approx(2 * pi * pi * 2 * 0.25).epsilon(1e-2));
  }

  TEST_CASE("the bending tube is one closed surface with a seam and hard rims in its wedges") {
    const int around = 16, rings = 20, joints = 5;
    const Character c = bending_tube(around, rings, joints);
    const Surface& s = c.surface;
    check_closed(s, 2);
    check_tables(s);
    // One more wedge a ring for the seam, one a rim vertex and end for the caps, one a cap for the cap's
    // seam.
    CHECK(int(s.wedges.size()) == int(s.position.size()) + (rings + 1) + 2 * around + 2);
    std::set<int> used(s.corners.begin(), s.corners.end());
    CHECK(used.size() == s.wedges.size());
    for (int f = 0; f < s.face_count(); ++f) {
      const auto face = s.face(f);
      double low = 1, high = 0;
      Vec3 normal = Vec3::Zero();
      for (const int w : face) {
        const double u = s.attributes(w, s.layout.uv_at(0));
        if (vertex(s, w) < (rings + 1) * around) low = std::min(low, u), high = std::max(high, u);
        normal += s.attributes.row(w).head<3>().transpose();
      }
      CHECK(high - low < 1.5 / around);  // no face runs back across the whole texture
      const Vec3& a = s.position[size_t(vertex(s, face[0]))];
      const Vec3& b = s.position[size_t(vertex(s, face[1]))];
      CHECK((b - a).cross(s.position[size_t(vertex(s, face[2]))] - a).dot(normal) > 0);
    }
    REQUIRE(c.clips.size() == 2);
    CHECK(c.clips[0].name == "bend");
    CHECK(c.clips[1].duration() == 1);
    CHECK(c.parts.size() == 1);
    CHECK(c.skeleton.nodes[size_t(c.parts[0].node)].name == "body");
    const Palette rest = palette(c.skeleton, globals(c.skeleton, rest_locals(c.skeleton)));
    for (const Affine& T : rest) CHECK(T == identity());
  }

  TEST_CASE("the square column has the paper's 114688 triangles") {
    const Character c = square_column();
    CHECK(c.surface.face_count() == 114688);
    CHECK(volume(c.surface) == doctest::Approx(8).epsilon(1e-9));
    const Character small = square_column(4, 20);
    check_closed(small.surface, 2);
    check_tables(small.surface);
    CHECK(diagonal(small.surface.position) == doctest::Approx(std::sqrt(66.0)).epsilon(1e-12));
    CHECK(small.clips.size() == 2);
    double low = 1, high = 0;
    for (const Vec3& x : small.surface.position) low = std::min(low, x.y()), high = std::max(high, x.y());
    CHECK(low == 0);
    CHECK(high == 8);
  }
}
