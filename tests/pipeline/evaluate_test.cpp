// SPDX-License-Identifier: MIT
#include "pipeline/evaluate.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include "pipeline/farthest.h"
#include "pipeline/parallel.h"
#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

PosedError between(const Surface& a, const Surface& b, const Pose& pose, int samples = 4000) {
  const Surface* other[] = {&b};
  return posed_error(deviations(a, other, {&pose, 1}, {.samples = samples}).front());
}

// Faces without neighbours, their corners wherever `point` puts them.
template <class Point>
Surface soup(int faces, const Point& point) {
  Surface s;
  for (int v = 0; v < 3 * faces; ++v) s.position.push_back(point()), s.wedges.push_back({v, 0});
  for (int f = 0; f < faces; ++f) s.add_face(std::vector{3 * f, 3 * f + 1, 3 * f + 2});
  s.influences.assign(s.position.size(), {{0, 1.0}});
  return s;
}

// The largest distance of very many points of `a` from `b` in the pose: every face is asked.
double brute_force(const Surface& a, const Surface& b, const Pose& pose, int count) {
  const PosedSurface from(a, pose_vertices(a, pose.palette)), to(b, pose_vertices(b, pose.palette));
  double most = 0;
  for (const Place& s : sample_by_area(a, count)) {
    double least = std::numeric_limits<double>::infinity();
    for (int f = 0; f < b.face_count(); ++f)
      least = std::min(least, to.squared_distance(from.at(s.face, s.share), f));
    most = std::max(most, least);
  }
  return std::sqrt(most);
}

// A surface as it is looked over, in four poses.
struct Looked {
  Looked(const Surface& s, const Sketch::PerPose<Palette>& palettes, const Sketch::PerPose<Vec3>& centres)
      : tree(s),
        sketch(tree,
               {pose_vertices(s, palettes[0]), pose_vertices(s, palettes[1]), pose_vertices(s, palettes[2]),
                pose_vertices(s, palettes[3])},
               centres) {}
  FaceTree tree;
  Sketch sketch;
};

const Pose kStill{"bind", Palette(8, identity())};

}  // namespace

TEST_SUITE("evaluate") {
  TEST_CASE("a surface has no distance from itself in any pose") {
    const Surface s = bending_tube(16, 16, 4).surface;
    for (unsigned seed = 0; seed < 3; ++seed) {
      const PosedError e = between(s, s, {"random", random_palette(4, seed, 1, 1)});
      CHECK(e.rms < 1e-12);
      CHECK(e.max < 1e-4);
    }
  }

  TEST_CASE("a flat sheet moved along its normal is that far away") {
    Surface s = grid_box(Vec3(1, 1, 1), 4), up = s;
    s.corners.resize(96), s.face_begin.resize(33);
    up.corners = s.corners, up.face_begin = s.face_begin;
    const Vec3 n = (s.position[s.corners[1]] - s.position[s.corners[0]])
                       .cross(s.position[s.corners[2]] - s.position[s.corners[0]])
                       .normalized();
    for (Vec3& x : up.position) x += 0.25 * n;
    const PosedError e = between(s, up, kStill);
    CHECK(e.rms == doctest::Approx(0.25));
    CHECK(e.max == doctest::Approx(0.25));
  }

  TEST_CASE("concentric spheres are apart by the difference of their radii") {
    const Surface s = sphere(5);
    Surface larger = s;
    for (Vec3& x : larger.position) x *= 1.1;
    CHECK(between(s, larger, kStill).rms == doctest::Approx(0.1).epsilon(0.01));
  }

  TEST_CASE("a missing part is seen from one side and counts there") {
    Surface whole = sphere(4), half = whole;
    half.corners.clear(), half.face_begin = {0};
    for (int f = 0; f < whole.face_count(); ++f) {
      double y = 0;
      for (const int w : whole.face(f)) y += whole.position[w].y();
      if (y > 0) half.add_face(whole.face(f));
    }
    const PosedError a = between(whole, half, kStill), b = between(half, whole, kStill);
    CHECK(a.max >= 0.98 * std::sqrt(2.0));  // the south pole to the equator
    CHECK(a.max <= std::sqrt(2.0) * (1 + kBoundSlack));
    CHECK(a.rms == doctest::Approx(b.rms).epsilon(0.02));  // both directions are in either
  }

  TEST_CASE("the pose counts: weights alone make a distance") {
    const Surface s = bending_tube(16, 16, 4).surface;
    Surface stiff = s;
    for (Influences& i : stiff.influences) i = {{0, 1.0}};
    CHECK(between(s, stiff, kStill).max < 1e-4);
    Pose pose = kStill;
    for (int b = 1; b < 8; ++b) pose.palette[b].col(3) = Vec3(0.5, 0, 0);
    CHECK(between(s, stiff, pose).max > 0.3);
  }

  TEST_CASE("far from the origin the distance keeps its digits") {
    const Surface s = sphere(4);
    Surface larger = s;
    for (Vec3& x : larger.position) x *= 1.001;
    Pose far = kStill;
    for (Affine& T : far.palette) T.col(3) = Vec3(1000, -2000, 500);
    CHECK(between(s, larger, far).rms == doctest::Approx(between(s, larger, kStill).rms).epsilon(1e-6));
  }

  TEST_CASE("one thread and two give the same bits") {
    const Surface s = bending_tube(16, 16, 4).surface, t = bending_tube(9, 8, 4).surface;
    std::vector<Pose> poses;
    for (unsigned seed = 0; seed < 6; ++seed) poses.push_back({"random", random_palette(4, seed, 1, 1)});
    const auto run = [&](int threads) {
      const ThreadLimit limit(threads);
      const Surface* other[] = {&t};
      return deviations(s, other, poses, {.attributes = true}).front();
    };
    const auto one = run(1), two = run(2);
    for (size_t p = 0; p < poses.size(); ++p) {
      CHECK(one[p].distance == two[p].distance);
      CHECK(one[p].bound == two[p].bound);
      CHECK(one[p].normal == two[p].normal);
      CHECK(one[p].uv == two[p].uv);
      CHECK(one[p].bound > 0);
    }
  }

  TEST_CASE("the closest point is the one that asking every face finds") {
    const Surface a = bending_tube(12, 10, 4).surface, b = bending_tube(7, 6, 4).surface;
    for (unsigned seed = 0; seed < 3; ++seed) {
      const Palette palette = random_palette(4, seed, 1, 1);
      const PosedSurface from(a, pose_vertices(a, palette)), to(b, pose_vertices(b, palette));
      int guess = 0;
      for (const Place& s : sample_by_area(a, 500)) {
        const Vec3 x = from.at(s.face, s.share);
        const ClosestPoint there = to.closest(x, guess);
        guess = (guess + 13) % b.face_count();
        double least = std::numeric_limits<double>::infinity();
        int first = -1;
        for (int f = 0; f < b.face_count(); ++f) {
          if (to.squared_distance(x, f) < least) least = to.squared_distance(x, f), first = f;
        }
        CHECK(there.squared == least);
        CHECK(there.face == first);
        CHECK((to.at(there.face, there.share) - x).squaredNorm() == least);
      }
    }
  }

  TEST_CASE("of faces in any heap, far and near, the closest is the one that asking every face finds") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto any = [&] { return Vec3(unit(random), unit(random), unit(random)); };
    for (const int faces : {1, 2, 4, 5, 16, 17, 300}) {
      CAPTURE(faces);
      const Surface rest = soup(faces, any);
      const auto tree = std::make_shared<FaceTree>(rest);
      for (const double size : {1.0, 1e-3, 1e4}) {
        // Posed otherwise than at rest, some corners together and some faces twice.
        std::vector<Vec3> points;
        for (size_t v = 0; v < rest.position.size(); ++v) points.push_back(size * (any() + Vec3(5, 0, 0)));
        for (size_t v = 0; v + 5 < points.size(); v += 15)
          points[v + 1] = points[v], points[v + 3] = points[v];
        for (size_t v = 0; v + 8 < points.size(); v += 21) {
          for (size_t k = 0; k < 3; ++k) points[v + 3 + k] = points[v + k];
        }
        const PosedSurface posed(tree, points);
        for (int i = 0; i < 60; ++i) {
          const Vec3 x =
              i % 3 == 0 ? points[size_t(i) % points.size()] : Vec3(size * (i % 3 == 1 ? 6 : 1e5) * any());
          const ClosestPoint there = posed.closest(x, i % faces);
          double least = std::numeric_limits<double>::infinity();
          int first = -1;
          for (int f = 0; f < faces; ++f) {
            const double squared = posed.squared_distance(x, f);
            if (squared < least) least = squared, first = f;
          }
          CHECK(there.squared == least);
          CHECK(there.face == first);
        }
      }
    }
  }

  TEST_CASE("every face is in one box of a tree, and every box but the first in one before it") {
    for (const int n : {1, 3, 11}) {
      const Surface s = sheet(n);
      const FaceTree tree(s);
      std::vector<int> faces(size_t(s.face_count())), boxes(tree.boxes().size());
      for (size_t box = 0; box < boxes.size(); ++box) {
        for (const int in : tree.boxes()[box]) {
          if (in < 0) ++faces[size_t(~in)];
          if (in > 0) ++boxes[size_t(in)];
          CHECK((in <= 0 || size_t(in) > box));
        }
      }
      CHECK(std::ranges::count(faces, 1) == s.face_count());
      CHECK(std::count(boxes.begin() + 1, boxes.end(), 1) == std::ptrdiff_t(boxes.size()) - 1);
      CHECK(boxes.front() == 0);
    }
  }

  TEST_CASE("a cover is all of a surface, and near in the pose it is made in") {
    const Surface fine = bending_tube(24, 30, 4).surface, coarse = bending_tube(7, 6, 4).surface;
    const Palette palette = random_palette(4, 1, 1, 1);
    const PosedSurface a(fine, pose_vertices(fine, palette)), b(coarse, pose_vertices(coarse, palette));
    for (const auto& [from, to] : {std::pair(&a, &b), std::pair(&b, &a)}) {
      const Cover made = cover(*from, *to, 0, kBoundSlack);
      std::vector<double> share(size_t(from->surface().face_count()));
      CHECK(made.pieces.size() > share.size());
      double most = 0;
      for (size_t i = 0; i < made.pieces.size(); ++i) {
        const auto& [face, near, end] = made.pieces[i];
        const auto ring = made.ring(i);
        for (size_t k = 0; k < ring.size(); ++k) {
          const Vec3 p = ring[k].share, q = ring[(k + 1) % ring.size()].share;
          share[size_t(face)] += p[1] * q[2] - q[1] * p[2];  // twice the area, of a face of 1/2
          const double apart = (from->at(face, p) - to->at(near, ring[k].there)).norm();
          CHECK(apart == doctest::Approx(std::sqrt(to->squared_distance(from->at(face, p), near))));
          most = std::max(most, apart);
        }
      }
      for (const double whole_face : share) CHECK(whole_face == doctest::Approx(1));
      const Looked looked(from->surface(), {palette, palette, palette, palette}, {});
      const Looked at(to->surface(), {palette, palette, palette, palette}, {});
      const auto bound_by = [&, from = from, to = to](const Cover& cover) {
        const auto all = doubts(looked.sketch, at.sketch, {}, cover).front();
        CHECK(all.size() == cover.pieces.size());
        return squared_bound(*from, *to, 0, kBoundSlack, cover, all);
      };
      const double squared = bound_by(made), bound = std::sqrt(squared);
      CHECK(bound <= most * (1 + 1e-12));
      CHECK(most <= (1 + kBoundSlack) * bound);
      const Cover coarser = cover(*from, *to, 16 * squared, kBoundSlack);
      CHECK(coarser.pieces.size() < made.pieces.size());
      CHECK(bound_by(coarser) == doctest::Approx(squared).epsilon(0.21));
    }
  }

  TEST_CASE("a piece of a cover that is in no doubt is nearer than what is known, far from the origin too") {
    const Surface fine = bending_tube(24, 30, 4).surface, coarse = bending_tube(7, 6, 4).surface;
    Sketch::PerPose<Palette> palettes;
    Sketch::PerPose<Vec3> centres;
    for (unsigned p = 0; p < 4; ++p) {
      palettes[p] = random_palette(4, p, 1, 1);
      for (Affine& T : palettes[p]) T.col(3) += 1000.0 * p * Vec3(1, -2, 3);
      centres[p] = pose_vertices(fine, palettes[p]).front();
    }
    const Looked fine_looked(fine, palettes, centres), coarse_looked(coarse, palettes, centres);
    const PosedSurface a(fine, pose_vertices(fine, palettes[0])),
        b(coarse, pose_vertices(coarse, palettes[0]));
    const Cover made = cover(a, b, 0, kBoundSlack);
    for (size_t p = 0; p < 4; ++p) {
      const PosedSurface from(fine, pose_vertices(fine, palettes[p])),
          to(coarse, pose_vertices(coarse, palettes[p]));
      std::vector<double> upper;
      for (size_t i = 0; i < made.pieces.size(); ++i) {
        const auto& [face, near, end] = made.pieces[i];
        double& most = upper.emplace_back();
        for (const Cover::Corner& c : made.ring(i))
          most = std::max(most, (from.at(face, c.share) - to.at(near, c.there)).squaredNorm());
      }
      // As tight as can be: the distance of one of them itself.
      for (const double known : {upper[upper.size() / 2], upper[upper.size() / 3], upper.back()}) {
        Sketch::PerPose<double> of_each;
        of_each.fill(std::numeric_limits<double>::infinity());
        of_each[p] = known;
        const auto found = doubts(fine_looked.sketch, coarse_looked.sketch, of_each, made);
        std::vector<bool> is_in_doubt(upper.size());
        for (const int piece : found[p]) is_in_doubt[size_t(piece)] = true;
        for (size_t i = 0; i < upper.size(); ++i) {
          CHECK((is_in_doubt[i] || upper[i] < known));
          CHECK((!is_in_doubt[i] || upper[i] > 0.999 * known));
        }
        for (size_t k = 1; k < found[p].size(); ++k)
          CHECK(upper[size_t(found[p][k])] <= upper[size_t(found[p][k - 1])] * (1 + 1e-4));
        CHECK(!found[p].empty());
        CHECK(found[p].size() < upper.size());
        CHECK(found[(p + 1) % 4].empty());
      }
    }
  }

  TEST_CASE("a surface is no distance from itself, the bound neither") {
    Surface s = bending_tube(24, 30, 4).surface;
    for (int f = 0, once = s.face_count(); f < once; ++f) {
      const std::span<const int> face = s.face(f);
      const std::array<int, 3> turned{face[1], face[2], face[0]};  // another order of its corners
      s.add_face(turned);
    }
    for (unsigned seed = 0; seed < 4; ++seed) {
      const Pose pose{"random", random_palette(4, seed, 1, 1)};
      CHECK(between(s, s, pose, 500).max <= 1e-12);
    }
  }

  TEST_CASE("the largest distance is a bound, and a near one") {
    const Surface fine = bending_tube(32, 40, 4).surface;
    for (const Surface& coarse : {bending_tube(5, 4, 4).surface, bending_tube(9, 8, 4).surface}) {
      for (unsigned seed = 0; seed < 3; ++seed) {
        const Pose pose{"random", random_palette(4, seed, 1, 1)};
        const double dense =
            std::max(brute_force(fine, coarse, pose, 20000), brute_force(coarse, fine, pose, 2000));
        const PosedError few = between(fine, coarse, pose, 50);
        CHECK(few.max >= dense);
        CHECK(few.max <= 1.2 * dense);
        CHECK(few.p99 < few.max);
        CHECK(few.mean < few.rms);
      }
    }
  }

  TEST_CASE("a bump that no sample hits is in the largest distance all the same") {
    const Surface flat = sheet(64);
    Surface bump = flat;
    bump.position[32 * 65 + 32].z() = 0.25;
    const Surface* other[] = {&bump};
    const auto found = deviations(flat, other, {&kStill, 1}, {.samples = 16}).front().front();
    CHECK(spread(found.distance).max < 0.1);
    CHECK(found.bound >= 0.25);
    CHECK(found.bound <= 0.25 * (1 + kBoundSlack));
  }

  TEST_CASE("a bent tube is as far from the true bend as its chords are") {
    // A tube of n sides lies within the unit cylinder: mean squared sagitta of the chord in closed form.
    constexpr int kAround = 16;
    const Surface coarse = tube(kAround, 1, 1), fine = tube(kAround * 64, 1, 1);
    const double half = 3.14159265358979 / kAround, apothem = std::cos(half), side = std::sin(half);
    const double mean =
        1 - (apothem + side * side / (3 * apothem) / 2);  // of |x| along a chord, to 2nd order
    const PosedError e = between(fine, coarse, kStill, 20000);
    CHECK(e.max >= 1 - apothem);
    CHECK(e.max <= (1 - apothem) * (1 + kBoundSlack));
    CHECK(e.mean == doctest::Approx(mean).epsilon(0.01));
  }

  TEST_CASE("normals and uvs are compared at the closest points") {
    Surface s = bending_tube(32, 32, 4).surface, t = s;
    const AttributeLayout& layout = s.layout;
    REQUIRE(layout.normal);
    REQUIRE(layout.uv_sets == 1);
    for (Eigen::Index w = 0; w < t.attributes.rows(); ++w) {
      t.attributes(w, layout.uv_at(0)) += 0.125;
      const Vec3 n = t.attributes.row(w).segment<3>(layout.normal_at());
      Vec3 across = n.cross(Vec3::UnitY());
      if (across.norm() < 0.5) across = n.cross(Vec3::UnitX());
      t.attributes.row(w).segment<3>(layout.normal_at()) = (n + across.normalized()).normalized();
    }
    const Surface* other[] = {&t};
    const Pose pose{"random", random_palette(4, 5, 1, 1)};
    const auto turned =
        deviations(s, other, {&pose, 1}, {.samples = 2000, .attributes = true}).front().front();
    CHECK(spread(turned.uv).rms == doctest::Approx(0.125).epsilon(1e-9));
    const double quarter = 3.14159265358979 / 4;
    CHECK(spread(turned.normal).mean == doctest::Approx(quarter).epsilon(0.03));
    CHECK(turned.tangent.empty());
    const Surface* itself[] = {&s};
    const auto same =
        deviations(s, itself, {&pose, 1}, {.samples = 2000, .attributes = true}).front().front();
    CHECK(spread(same.uv).max < 1e-9);
    CHECK(spread(same.normal).max < 1e-6);
  }

  TEST_CASE(
      "a sheet with a back in the same place has the normals that it has, and the back those of the back") {
    Surface front = sheet(4);  // shaded by its faces
    front.layout = {}, front.attributes.resize(front.attributes.rows(), 0);
    Surface card = front;
    for (int f = 0, faces = card.face_count(); f < faces; ++f) {
      const auto w = card.face(f);
      card.add_face(std::vector{w[0], w[2], w[1]});
    }
    const Surface* itself[] = {&card};
    const Pose still{"still", {identity()}};
    const auto found =
        deviations(card, itself, {&still, 1}, {.samples = 500, .attributes = true, .bound = false});
    REQUIRE(found[0][0].normal.size() == 1000);
    CHECK(spread(found[0][0].normal).max < 1e-12);
    const Surface* one_side[] = {&front};
    const auto missing =
        deviations(card, one_side, {&still, 1}, {.samples = 500, .attributes = true, .bound = false});
    CHECK(spread(missing[0][0].normal).max == doctest::Approx(3.14159265358979));
  }

  TEST_CASE("the share of a joint is what happens where it leads") {
    const Surface s = bending_tube(16, 40, 4).surface;
    Surface wide = s;
    for (size_t v = 0; v < wide.position.size(); ++v) {
      if (wide.influences[v].front().joint == 2 && wide.influences[v].size() == 1) wide.position[v] *= 1.2;
    }
    const Surface* other[] = {&wide};
    const auto found = deviations(s, other, {&kStill, 1}, {.samples = 2000}).front();
    auto follows = joints_of(s, sample_by_area(s, 2000));
    for (const Influences& i : joints_of(wide, sample_by_area(wide, 2000))) follows.push_back(i);
    const auto of = shares(follows, found, 4);
    CHECK(of[2].rms > 10 * of[0].rms);
    CHECK(of[2].max > 0.1);
    double weighted = 0, all = 0;
    for (const Influences& i : follows) {
      for (const Influence& influence : i) all += influence.weight;
    }
    for (int j = 0; j < 4; ++j) {
      double weight = 0;
      for (const Influences& i : follows) {
        for (const Influence& influence : i) weight += influence.joint == j ? influence.weight : 0;
      }
      weighted += weight * of[j].rms * of[j].rms;
    }
    CHECK(std::sqrt(weighted / all) == doctest::Approx(posed_error(found).rms).epsilon(1e-9));
  }
}
