// SPDX-License-Identifier: MIT
#include "pipeline/mesh.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "pipeline/collapse.h"
#include "pipeline/metrics/rest_pose.h"
#include "pipeline/metrics/surface_quadrics.h"
#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

// A fan of `n` triangles around vertex 0, open where `closed` is false.
Surface fan(int n, bool closed) {
  Surface s;
  s.position.push_back(Vec3::Zero());
  for (int i = 0; i < n + !closed; ++i) {
    const double angle = 6.28318530717958 * i / n;
    s.position.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  s.influences.assign(s.position.size(), {{0, 1.0}});
  for (int v = 0; v < int(s.position.size()); ++v) s.wedges.push_back({v, 0});
  s.attributes.resize(Eigen::Index(s.wedges.size()), 0);
  for (int i = 0; i < n; ++i) s.add_face(std::array{0, 1 + i, 1 + (closed ? (i + 1) % n : i + 1)});
  return s;
}

Surface tetrahedron() {
  Surface s = fan(3, true);
  s.position[0] = Vec3(0, 0, 1);
  s.add_face(std::array{3, 2, 1});
  return s;
}

}  // namespace

TEST_SUITE("mesh") {
  TEST_CASE("a collapse in a closed surface takes two triangles and one vertex") {
    const Surface s = sphere(2);
    Mesh mesh(s);
    const Edge e = mesh.edges().front();
    REQUIRE(mesh.refusal(e) == Refusal::None);
    mesh.collapse(e, mesh.position[e.kept]);
    CHECK(mesh.triangle_count() == 126);
    CHECK_FALSE(mesh.alive(e.removed));
    CHECK(euler_characteristic(mesh.surface(s.influences)) == 2);
  }

  TEST_CASE("no edge of a tetrahedron may be collapsed") {
    const Mesh mesh(tetrahedron());
    REQUIRE(mesh.edges().size() == 6);
    for (const Edge e : mesh.edges()) CHECK(mesh.refusal(e) == Refusal::Link);
  }

  TEST_CASE("no edge of a lone triangle may be collapsed") {
    Surface s = fan(1, false);
    const Mesh mesh(s);
    for (const Edge e : mesh.edges()) CHECK(mesh.refusal(e) == Refusal::Link);
  }

  TEST_CASE("an edge between two borders would join them") {
    const Mesh mesh(fan(3, false));
    CHECK(mesh.refusal({0, 2}) == Refusal::Border);
    CHECK(mesh.refusal({1, 2}) == Refusal::None);
  }

  TEST_CASE("an edge of three faces is a line that is not joined to another") {
    Surface s = fan(4, true);
    s.position.emplace_back(0, 0, 1);
    s.influences.push_back({{0, 1.0}});
    s.wedges.push_back({5, 0});
    s.attributes.resize(6, 0);
    s.add_face(std::array{0, 1, 5});
    const Mesh mesh(s);
    CHECK(mesh.kind(0) == Kind::Singular);
    CHECK(mesh.refusal({0, 3}) == Refusal::Border);  // 0 is on the line, 3 on the border
    CHECK(mesh.on_border({1, 2}));
    CHECK_FALSE(mesh.on_border({0, 1}));
  }

  TEST_CASE("a vertex where two fans meet in a point is singular") {
    Surface s = fan(6, true);
    s.corners.erase(s.corners.begin() + 9, s.corners.begin() + 12);
    s.corners.erase(s.corners.begin(), s.corners.begin() + 3);
    s.face_begin = {0, 3, 6, 9, 12};
    CHECK(Mesh(s).kind(0) == Kind::Singular);

    // Two closed fans: every edge has two faces, and still the point is no surface.
    Surface two = sphere(0);
    const int n = int(two.position.size());
    const Surface other = sphere(0);
    for (int v = 0; v < n; ++v) {
      two.position.push_back(other.position[v] + Vec3(2, 0, 0));
      two.influences.push_back({{0, 1.0}});
      two.wedges.push_back({n + v == n + 1 ? 0 : n + v, 0});  // its (-1, 0, 0) is our (1, 0, 0)
    }
    two.attributes.resize(2 * n, 0);
    for (int f = 0; f < other.face_count(); ++f) {
      std::array<int, 3> face{};
      for (size_t i = 0; i < 3; ++i) face[i] = n + other.face(f)[i];
      two.add_face(face);
    }
    const Mesh mesh(two);
    CHECK(mesh.kind(0) == Kind::Singular);
    CHECK(mesh.kind(2) == Kind::Inner);
    CHECK(mesh.refusal({0, 2}) == Refusal::None);
  }

  TEST_CASE("a card with faces on its back is simplified on both sides at once") {
    Surface s = grid_box(Vec3(1, 1, 1), 6);
    s.corners.resize(6 * 6 * 2 * 3), s.face_begin.resize(6 * 6 * 2 + 1);
    for (int f = 6 * 6 * 2 - 1; f >= 0; --f) {
      const auto front = s.face(f);
      s.add_face(std::array{front[0], front[2], front[1]});
    }
    Mesh mesh(s);
    CHECK(mesh.triangle_count() == 144);
    RestPoseMetric metric(mesh, s.influences);
    collapse(mesh, metric, 0);
    CHECK(mesh.triangle_count() <= 4);
    CHECK(area(mesh.surface(metric.influences())) == doctest::Approx(2).epsilon(0.51));
    Mesh square(s);
    RestPoseMetric square_metric(square, s.influences);
    collapse(square, square_metric, 4);
    CHECK(square.triangle_count() == 4);
    CHECK(area(square.surface(square_metric.influences())) == doctest::Approx(2).epsilon(1e-6));
  }

  TEST_CASE("quads lose a corner and become triangles") {
    Surface s = fan(4, true);
    s.corners = {0, 1, 2, 3, 0, 3, 4, 1};
    s.face_begin = {0, 4, 8};
    Mesh two(s);
    CHECK(two.triangle_count() == 4);
    REQUIRE(two.refusal({0, 3}) == Refusal::None);
    two.collapse({0, 3}, two.position[0]);
    CHECK(two.triangle_count() == 2);
    s.corners = {0, 1, 2, 3};
    s.face_begin = {0, 4};
    Mesh one(s);
    REQUIRE(one.refusal({0, 1}) == Refusal::None);
    one.collapse({0, 1}, one.position[0]);
    CHECK(one.triangle_count() == 1);
    CHECK(one.face(0).size() == 3);
  }

  TEST_CASE("seams: a vertex beside one goes over into it, and the other way its chart stretches") {
    const Character c = bending_tube(12, 6, 3);
    const Mesh mesh(c.surface);
    // Vertex 24 is on the seam (first column, third ring), 25 beside it, 36 above it on the seam.
    CHECK(mesh.on_seam({24, 36}));
    CHECK_FALSE(mesh.on_seam({24, 25}));
    CHECK(mesh.refusal({24, 25}) == Refusal::None);
    CHECK(mesh.refusal({25, 24}) == Refusal::None);
    CHECK(mesh.stretches_a_chart({25, 24}));
    for (const Edge held : {Edge{24, 25}, Edge{24, 36}}) {
      CHECK_FALSE(mesh.stretches_a_chart(held));
      CHECK(mesh.stretch(held, mesh.position[24]) == 0);
    }
    // Three triangles are on the seam's other side.
    double area = 0;
    for (const int f : mesh.faces_around(24)) {
      const auto v = mesh.face(f);
      const Vec3 u = mesh.position[v[1]] - mesh.position[v[0]], w = mesh.position[v[2]] - mesh.position[v[0]];
      area += u.cross(w).norm() / 2;
    }
    CHECK(mesh.faces_around(24).size() == 6);
    const double squared = (mesh.position[25] - mesh.position[24]).squaredNorm();
    CHECK(mesh.stretch({25, 24}, mesh.position[25]) == doctest::Approx(area / 2 * squared));
    CHECK(mesh.refusal({24, 36}) == Refusal::None);
  }

  TEST_CASE("a collapse along a seam keeps both sheets and blends each with its own") {
    const Character c = bending_tube(12, 6, 3);
    Mesh mesh(c.surface);
    mesh.collapse({24, 36}, (mesh.position[24] + mesh.position[36]) / 2);
    const Surface s = mesh.surface(c.surface.influences);
    std::vector<double> u;
    for (size_t w = 0; w < s.wedges.size(); ++w) {
      const Vec3& x = s.position[s.wedges[w].vertex];
      if (x == mesh.position[24]) {
        u.push_back(s.attributes(Eigen::Index(w), s.layout.uv_at(0)));
        CHECK(s.attributes(Eigen::Index(w), s.layout.uv_at(0) + 1) == doctest::Approx(2.5 / 6));
        CHECK(s.attributes.row(Eigen::Index(w)).head<3>().norm() == doctest::Approx(1));
      }
    }
    std::sort(u.begin(), u.end());
    CHECK(u == std::vector<double>{0, 1});
  }

  TEST_CASE("wedges that differ in their normal alone do not hold a collapse") {
    // Every face with wedges and a normal of its own, as an un-indexed faceted mesh has.
    Surface flat = grid_box(Vec3(1, 1, 1), 4), s = flat;
    s.layout.normal = true;
    s.wedges.clear();
    s.attributes.resize(Eigen::Index(flat.corners.size()), 3);
    for (int f = 0; f < flat.face_count(); ++f) {
      const auto at = [&](int i) { return flat.position[flat.corners[3 * f + i]]; };
      const Vec3 n = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
      for (int i = 0; i < 3; ++i) {
        s.corners[3 * f + i] = int(s.wedges.size());
        s.attributes.row(Eigen::Index(s.wedges.size())) = n.transpose();
        s.wedges.push_back({flat.corners[3 * f + i], 0});
      }
    }
    Mesh mesh(s);
    int legal = 0;
    for (const Edge e : mesh.edges()) legal += mesh.refusal(e) == Refusal::None;
    CHECK(legal == int(mesh.edges().size()));

    const Edge e = mesh.edges().front();
    mesh.collapse(e, (mesh.position[e.kept] + mesh.position[e.removed]) / 2 + Vec3(0.01, 0.02, 0.03));
    const Surface after = mesh.surface(s.influences);
    for (int f = 0; f < after.face_count(); ++f) {
      const auto at = [&](int i) { return after.position[after.wedges[after.face(f)[i]].vertex]; };
      const Vec3 n = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
      for (const int w : after.face(f)) {
        const Vec3 shading = after.attributes.row(w).transpose();
        CHECK((shading - n).norm() < 1e-9);  // facets stay facets
      }
    }
  }

  TEST_CASE("a locked vertex may be kept and never removed") {
    const Surface s = fan(6, true);
    const Mesh mesh(s, Borders::Locked);
    CHECK(mesh.kind(0) == Kind::Inner);
    CHECK(mesh.kind(1) == Kind::Locked);
    CHECK(mesh.refusal({1, 0}) == Refusal::None);
    CHECK(mesh.refusal({0, 1}) == Refusal::Locked);
    CHECK(mesh.refusal({1, 2}) == Refusal::Locked);
    CHECK(Mesh(s).refusal({1, 2}) == Refusal::None);
    CHECK(locked_vertices(s, Borders::Locked) == std::vector<char>{0, 1, 1, 1, 1, 1, 1});
    CHECK(locked_vertices(s, Borders::Free) == std::vector<char>(7, 0));
  }

  TEST_CASE("charts so small that no edge continues stretch") {
    // A box of which every square is a chart of its own, and the squares of two sides of another material.
    Surface flat = grid_box(Vec3(1, 1, 1), 4), s = flat;
    const auto material = [&](const Wedge& w) { return flat.position[w.vertex].x() > 0; };
    s.layout.uv_sets = 1, s.wedges.clear();
    s.attributes.resize(Eigen::Index(2 * flat.face_count()), 2);
    for (int f = 0; f < flat.face_count(); f += 2) {
      std::map<int, int> wedge;
      const int part = std::ranges::all_of(flat.face(f), [&](int w) { return material(flat.wedges[w]); });
      for (int i = 3 * f; i < 3 * f + 6; ++i) {
        const int v = flat.corners[i];
        const auto [place, fresh] = wedge.try_emplace(v, int(s.wedges.size()));
        if (fresh) {
          const Vec3& x = flat.position[v];
          s.attributes.row(Eigen::Index(s.wedges.size())) << f + x.x() + 0.3 * x.z(), x.y() + 0.3 * x.z();
          s.wedges.push_back({v, part});
        }
        s.corners[i] = place->second;
      }
    }
    REQUIRE(int(s.wedges.size()) == 2 * flat.face_count());
    Mesh mesh(s);
    const auto legal = [&] {
      int count = 0, changes_material = 0;
      for (const Edge e : mesh.edges()) {
        for (const Edge way : {e, e.turned()}) {
          if (mesh.refusal(way) != Refusal::None) continue;
          ++count;
          std::set<int> removed, kept;
          for (const int f : mesh.faces_around(way.removed)) removed.insert(s.part(f));
          for (const int f : mesh.faces_around(way.kept)) kept.insert(s.part(f));
          changes_material += !std::ranges::includes(kept, removed);
        }
      }
      CHECK(changes_material == 0);
      return count;
    };
    CHECK(legal() > 100);
    for (const Edge e : mesh.edges()) {
      CHECK(mesh.stretches_a_chart(e));
      CHECK(mesh.stretch(e, mesh.position[e.removed]) == 0);
      CHECK(mesh.stretch(e, mesh.position[e.kept]) > 0);
    }

    Mesh stuck(s);
    RestPoseMetric metric(stuck, s.influences);
    collapse(stuck, metric, 40);
    CHECK(stuck.triangle_count() <= 40);
    CHECK(euler_characteristic(stuck.surface(s.influences)) == 2);
    const Surface after = stuck.surface(s.influences);
    const auto turn = [](const Surface& its, int f) {
      const auto uv = [&](int i) -> Vec2 { return its.attributes.row(its.face(f)[size_t(i)]).transpose(); };
      const Vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
      return a.x() * b.y() - a.y() * b.x();
    };
    int left = 0, turned = 0;
    for (int f = 0; f < stuck.face_slots(); ++f) {
      if (!stuck.face(f).empty()) turned += !(turn(s, f) * turn(after, left++) > 0);
    }
    CHECK(left == after.face_count());
    CHECK(turned == 0);
  }

  TEST_CASE("what the mesh gives back untouched is what it was given") {
    const Character c = bending_tube(8, 4, 2);
    const Surface s = Mesh(c.surface).surface(c.surface.influences);
    CHECK(s.position == c.surface.position);
    CHECK(s.corners.size() == c.surface.corners.size());
    for (int f = 0; f < s.face_count(); ++f) {
      for (size_t i = 0; i < 3; ++i) {
        const int a = s.face(f)[i], b = c.surface.face(f)[i];
        CHECK(s.wedges[a].vertex == c.surface.wedges[b].vertex);
        CHECK((s.attributes.row(a) - c.surface.attributes.row(b)).cwiseAbs().maxCoeff() < 0.3);
      }
    }
  }

  TEST_CASE("a collapse that turns a triangle over in texture space alone is seen") {
    // A fan around the last vertex; its texture has a dent at the corner 4, its points have none.
    Surface s;
    s.layout.uv_sets = 1;
    const std::vector<Vec2> uv = {{0, 0}, {2, 0}, {2, 2}, {0, 2}, {1.1, 1}, {1.2, 1}};
    const std::vector<Vec3> x = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {-1, 1, 0}, {1.2, 1, 0}};
    s.position = x;
    s.influences.assign(6, {{0, 1.0}});
    s.attributes.resize(6, 2);
    for (int v = 0; v < 6; ++v) {
      s.wedges.push_back({v, 0});
      s.attributes.row(v) = uv[size_t(v)].transpose();
    }
    for (int v = 0; v < 5; ++v) s.add_face(std::array{v, (v + 1) % 5, 5});
    const Mesh mesh(s);
    CHECK(mesh.refusal({1, 5}) == Refusal::None);
    CHECK(mesh.turns_a_uv({1, 5}, x[1]));   // beside the dent
    CHECK(!mesh.turns_a_uv({1, 5}, x[5]));  // stays
    CHECK(!mesh.turns_a_uv({4, 5}, x[4]));  // into the dent, which is seen from everywhere
    s.layout.uv_sets = 0, s.attributes.resize(6, 0);
    CHECK(!Mesh(s).turns_a_uv({1, 5}, x[1]));
  }

  TEST_CASE(
      "where a seam ends the sheets on both its sides come together, and what that turns over is seen") {
    // Two rings around the vertex 0. Uvs go around once, from a seam that ends at the middle.
    constexpr int kAround = 8;
    Surface s = fan(kAround, true);
    s.layout.uv_sets = 1;
    for (int i = 0; i < kAround; ++i) s.position.push_back(2 * s.position[1 + i]);
    s.influences.assign(s.position.size(), {{0, 1.0}});
    s.wedges = {{0, 0}}, s.corners.clear(), s.face_begin = {0};
    s.attributes.resize(1 + 2 * (kAround + 1), 2);
    s.attributes.row(0) << 0.5, 0;
    const auto wedge = [](int ring, int i) { return 1 + ring * (kAround + 1) + i; };
    for (int ring = 0; ring < 2; ++ring) {
      for (int i = 0; i <= kAround; ++i) {
        s.attributes.row(wedge(ring, i)) << double(i) / kAround, 0.5 + 0.5 * ring;
        s.wedges.push_back({1 + ring * kAround + i % kAround, 0});
      }
    }
    for (int i = 0; i < kAround; ++i) {
      s.add_face(std::array{0, wedge(0, i), wedge(0, i + 1)});
      s.add_face(std::array{wedge(0, i), wedge(1, i), wedge(1, i + 1)});
      s.add_face(std::array{wedge(0, i), wedge(1, i + 1), wedge(0, i + 1)});
    }
    const Mesh mesh(s);
    const Edge e{0, 1};
    REQUIRE(mesh.on_seam({1, 1 + kAround}));
    REQUIRE(mesh.refusal(e) == Refusal::None);
    for (const double t : {0.0, 0.5, 1.0}) {
      CAPTURE(t);
      const Vec3 to = t * s.position[1];
      const Traced after = traced(s, {{e, 0, to, {{0, 1.0}}}}, 1);
      for (size_t w = 0; w < after.surface.wedges.size(); ++w) {
        if (after.surface.wedges[w].vertex != 0) continue;
        const Vec2 uv = after.surface.attributes.row(Eigen::Index(w)).transpose();
        CHECK((uv - Vec2(0.5, 0.5 * t)).norm() < 1e-12);  // 0 and 1 meet in their middle
      }
      CHECK(turned_uvs(s, after.surface, after.face).turned > 0);
      CHECK(mesh.turns_a_uv(e, to));
    }
  }

  TEST_CASE("a face may not turn away from the source step by step") {
    const auto steep = [](const Surface& s) {
      Mesh mesh(s);
      mesh.collapse({12, 13}, {0.5, 0.6, 2}, {});
      return mesh;
    };
    const Surface flat = sheet(4);
    const Mesh mesh = steep(flat);
    const Edge e{12, 11};
    for (const MovedCorner& c : moved_corners(mesh, e))
      CHECK(!turns_over(mesh.position[c.moved], {0.5, 1.1, 2}, mesh.position[c.a], mesh.position[c.b]));
    CHECK(mesh.turns_from_source(e, {0.5, 1.1, 2}));  // leans out over the border at y = 1
    CHECK(!mesh.turns_from_source(e, {0.5, 0.9, 2}));

    Surface card = flat;
    for (int f = 0; f < flat.face_count(); ++f) {
      const auto [a, b, c] = triangle_vertices(flat, f);
      card.add_face(std::array{a, c, b});
    }
    CHECK(!steep(card).turns_from_source(e, {0.5, 1.1, 2}));  // that has two sides
  }
}
