// SPDX-License-Identifier: MIT
#include "pipeline/repair.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "pipeline/error.h"
#include "pipeline/pose.h"
#include "tests/random.h"
#include "tests/shapes.h"

using namespace skinlod;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::int64_t count(const Warnings& warnings, WarningCode code) {
  std::int64_t sum = 0;
  for (const Warning& w : warnings) sum += w.code == code ? w.count : 0;
  return sum;
}

// Two joints, two parts, and a strip of `quads` quads along x in part 0: vertex v is a wedge of its own.
Character strip(int quads) {
  Character c;
  c.name = "strip";
  c.skeleton.nodes = {{.name = "root"}, {.name = "tip", .parent = 0}, {.name = "mesh"}, {.name = "prop"}};
  c.skeleton.joints = {{0}, {1}};
  c.parts = {{.name = "cloth", .node = 2}, {.name = "buckle", .node = 3}};
  for (int i = 0; i <= quads; ++i) {
    for (const double y : {0.0, 1.0}) {
      c.surface.wedges.push_back({int(c.surface.position.size()), 0});
      c.surface.position.emplace_back(i, y, 0);
      c.surface.influences.push_back({{0, 0.25}, {1, 0.75}});
    }
  }
  for (int i = 0; i < quads; ++i) c.surface.add_face(std::array{2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1});
  c.surface.attributes.resize(Eigen::Index(c.surface.wedges.size()), 0);
  return c;
}

// Adds a vertex with one wedge; the wedge's index.
int add_vertex(Surface& s, const Vec3& x, const Influences& influences, int part = 0) {
  s.position.push_back(x);
  s.influences.push_back(influences);
  if (!s.morphs.empty()) s.morphs.push_back({});
  s.wedges.push_back({int(s.position.size()) - 1, part});
  s.attributes.conservativeResize(Eigen::Index(s.wedges.size()), s.layout.columns());
  s.attributes.bottomRows(1) = default_attributes(s.layout);
  return int(s.wedges.size()) - 1;
}

// The same surface as a file without indices has it: every corner a vertex of its own.
Surface exploded(const Surface& surface) {
  Surface s;
  s.layout = surface.layout;
  s.attributes.resize(Eigen::Index(surface.corners.size()), surface.attributes.cols());
  for (int f = 0; f < surface.face_count(); ++f) {
    std::vector<int> face;
    for (const int w : surface.face(f)) {
      const Wedge& wedge = surface.wedges[size_t(w)];
      const int its = int(s.wedges.size());
      s.position.push_back(surface.position[size_t(wedge.vertex)]);
      s.influences.push_back(surface.influences[size_t(wedge.vertex)]);
      s.wedges.push_back({its, wedge.part});
      s.attributes.row(its) = surface.attributes.row(w);
      face.push_back(its);
    }
    s.add_face(face);
  }
  return s;
}

void check_repaired(const Character& c) {
  for (const Vec3& x : c.surface.position) CHECK(x.allFinite());
  CHECK(c.surface.attributes.allFinite());
  for (const Influences& influences : c.surface.influences) {
    double sum = 0;
    int last = -1;
    for (const auto& [joint, weight] : influences) {
      CHECK(joint > last);
      CHECK(joint < int(c.skeleton.joints.size()));
      CHECK(weight > 0);
      last = joint, sum += weight;
    }
    CHECK(sum == doctest::Approx(1).epsilon(1e-14));
  }
  for (const int w : c.surface.corners) CHECK(size_t(w) < c.surface.wedges.size());
}

}  // namespace

TEST_SUITE("repair") {
  TEST_CASE("a sound character is left as it is and nothing is said") {
    Character c = bending_tube(12, 10, 4);
    const Character before = c;
    CHECK(repair(c).empty());
    CHECK(c.surface.corners == before.surface.corners);
    CHECK(c.surface.position == before.surface.position);
    CHECK((c.surface.attributes - before.surface.attributes).cwiseAbs().maxCoeff() < 1e-15);
    CHECK(c.clips.size() == before.clips.size());
    CHECK(c.clips[0].channels.size() == before.clips[0].channels.size());
    check_repaired(c);
  }

  TEST_CASE("influences are sorted and merged and scaled and counted by what was wrong") {
    Character c = strip(5);
    auto& influences = c.surface.influences;
    influences[0] = {{1, 0.5}, {0, 0.5}};              // unsorted: nothing wrong
    influences[1] = {{1, 0.25}, {0, 0.5}, {1, 0.25}};  // a joint twice: nothing wrong
    influences[2] = {{0, 2}, {1, 2}};                  // sum 4
    influences[3] = {{0, 1}, {1, -0.5}};
    influences[4] = {{0, 1}, {1, kNaN}};
    influences[5] = {{0, 1}, {7, 0.5}};
    influences[6] = {{0, 1}, {-1, 0}};  // padding: nothing wrong
    influences[7] = {{0, 1}, {1, 0}};   // padding: nothing wrong
    influences[8] = {{0, 1e308}, {1, 1e308}};
    const Warnings warnings = repair(c);
    check_repaired(c);
    CHECK(influences[0] == Influences{{0, 0.5}, {1, 0.5}});
    CHECK(influences[1] == Influences{{0, 0.5}, {1, 0.5}});
    CHECK(influences[2] == Influences{{0, 0.5}, {1, 0.5}});
    for (const size_t v : {3, 4, 5, 6, 7}) CHECK(influences[v] == Influences{{0, 1}});
    CHECK(count(warnings, WarningCode::WeightsNotNormalised) == 1);
    CHECK(count(warnings, WarningCode::WeightsNegative) == 1);
    CHECK(count(warnings, WarningCode::WeightsNotFinite) == 2);
    CHECK(count(warnings, WarningCode::InfluencesOutOfRange) == 1);
    CHECK(count(warnings, WarningCode::WeightsAbsent) == 1);
    CHECK(warnings.front().part == "cloth");
  }

  TEST_CASE("a vertex without influence follows the nearest of its part") {
    std::mt19937 random(1);
    Character c = strip(300);
    Surface& s = c.surface;
    for (size_t v = 0; v < s.position.size(); ++v) {
      s.position[v] += random_vector(random, 0.4);
      const double w = uniform(random, 0.1, 0.9);
      s.influences[v] = random() % 3 ? Influences{{0, w}, {1, 1 - w}} : Influences{};
    }
    // Nearer than all others, but of another part.
    const int a = add_vertex(s, s.position[0], {{1, 1}}, 1), b = add_vertex(s, {9, 9, 9}, {{1, 1}}, 1);
    s.add_face(std::array{a, b, add_vertex(s, {9, 9, 0}, {{1, 1}}, 1)});
    s.influences[0].clear();
    const Surface before = s;
    const Warnings warnings = repair(c);
    std::int64_t absent = 0;
    for (size_t v = 0; v < before.position.size(); ++v) {
      if (!before.influences[v].empty()) continue;
      ++absent;
      size_t nearest = 0;
      double least = kInfinity;
      for (size_t u = 0; u < before.position.size() - 3; ++u) {
        const double d = (before.position[u] - before.position[v]).squaredNorm();
        if (!before.influences[u].empty() && d < least) least = d, nearest = u;
      }
      CAPTURE(v);
      CHECK(s.influences[v] == s.influences[nearest]);
    }
    CHECK(absent > 100);
    CHECK(count(warnings, WarningCode::WeightsAbsent) == absent);
    check_repaired(c);
  }

  TEST_CASE("a part without any influence follows its node") {
    Character c = strip(2);
    Surface& s = c.surface;
    c.skeleton.nodes[3].rest.translation = Vec3(0, 5, 0);
    const int a = add_vertex(s, {0, 5, 0}, {}, 1), b = add_vertex(s, {1, 5, 0}, {}, 1);
    s.add_face(std::array{a, b, add_vertex(s, {0, 6, 0}, {{0, -1}}, 1)});
    const Warnings warnings = repair(c);
    CHECK(count(warnings, WarningCode::WeightsAbsent) == 3);
    REQUIRE(c.skeleton.joints.size() == 3);
    CHECK(c.skeleton.joints[2].node == 3);
    CHECK(s.influences[size_t(a)] == Influences{{2, 1}});
    const Palette T = palette(c.skeleton, globals(c.skeleton, rest_locals(c.skeleton)));
    CHECK(T[2] == identity());  // stands at rest where it stood
  }

  TEST_CASE("faces that cannot be drawn are removed and counted") {
    Character c = strip(3);
    Surface& s = c.surface;
    s.add_face(std::array{0, 2, 99});
    s.add_face(std::array{-1, 2, 3});
    s.add_face(std::array{0, 2});
    s.add_face(std::array{0, 2, 4});  // three corners on one line
    s.add_face(std::array{1, 1, 1});
    s.position[7] = Vec3(kNaN, 0, 0);  // a corner of the last quad
    const int loose = add_vertex(s, {kInfinity, 0, 0}, {});
    const Warnings warnings = repair(c);
    CHECK(s.face_count() == 2);
    CHECK(count(warnings, WarningCode::FaceOutOfRange) == 2);
    CHECK(count(warnings, WarningCode::FaceDegenerate) == 3);
    CHECK(count(warnings, WarningCode::PositionNotFinite) == 1);  // the loose vertex does not matter
    CHECK(s.position[size_t(loose)].allFinite());
    check_repaired(c);
  }

  TEST_CASE("slivers and concave polygons and twisted quads are faces") {
    Character c = strip(1);
    Surface& s = c.surface;
    const Influences all = {{0, 1}};
    const int n = 4;
    s.add_face(std::array{add_vertex(s, {0, 0, n}, all), add_vertex(s, {1, 0, n}, all),
                          add_vertex(s, {0.5, 1e-6, n}, all)});
    s.add_face(std::array{0, 3, 2, 1});  // a bow: its area vector is zero
    CHECK(count(repair(c), WarningCode::FaceDegenerate) == 0);
    CHECK(s.face_count() == 3);
  }

  TEST_CASE("attributes become finite and directions of unit length") {
    Character c = strip(2);
    Surface& s = c.surface;
    s.layout = {.normal = true, .tangent = true, .uv_sets = 1, .colour_sets = 1};
    s.attributes = default_attributes(s.layout).replicate(Eigen::Index(s.wedges.size()), 1);
    s.attributes.row(0).head<3>() << 3, 0, 4;
    s.attributes.row(1).head<3>() << 0, 0, 0;
    s.attributes(2, s.layout.tangent_at() + 3) = -0.99;
    s.attributes(3, s.layout.uv_at(0)) = kNaN;
    s.attributes(4, s.layout.colour_at(0) + 3) = kInfinity;
    const Warnings warnings = repair(c);
    check_repaired(c);
    CHECK((s.attributes.row(0).head<3>() - Eigen::RowVector3d(0.6, 0, 0.8)).norm() < 1e-15);
    CHECK(s.attributes.row(1) == default_attributes(s.layout));
    CHECK(s.attributes(2, s.layout.tangent_at() + 3) == -1);
    CHECK(s.attributes.row(3) == default_attributes(s.layout));
    CHECK(s.attributes.row(4) == default_attributes(s.layout));
    CHECK(count(warnings, WarningCode::AttributeNotFinite) == 3);
  }

  TEST_CASE("morph offsets are sorted and finite and of a morph that is there") {
    Character c = strip(1);
    c.morphs = {{"smile", 2}, {"frown", 2}};
    c.surface.morphs.resize(4);
    c.surface.morphs[0] = {{1, Vec3(1, 0, 0)}, {0, Vec3(0, 1, 0)}};
    c.surface.morphs[1] = {{0, Vec3(kNaN, 0, 0)}, {2, Vec3(1, 0, 0)}, {1, Vec3::Zero()}};
    const Warnings warnings = repair(c);
    CHECK(c.surface.morphs[0][0].morph == 0);
    CHECK(c.surface.morphs[0][1].morph == 1);
    CHECK(c.surface.morphs[1].empty());
    CHECK(count(warnings, WarningCode::AttributeNotFinite) == 2);
  }

  TEST_CASE("unused joints and clashing names and broken channels are told of") {
    Character c = strip(1);
    c.skeleton.nodes.push_back({.name = "tip", .parent = 0});
    c.skeleton.nodes.push_back({.name = "mesh"});  // twice, but no joint has it
    c.skeleton.joints.push_back({4});
    const Rows one = Rows::Zero(1, 3);
    c.clips = {{"run",
                {{0, Path::Translation, Interpolation::Linear, {0}, one},
                 {9, Path::Translation, Interpolation::Linear, {0}, one},
                 {0, Path::Translation, Interpolation::Linear, {0}, Rows::Constant(1, 3, kNaN)},
                 {0, Path::Translation, Interpolation::CubicSpline, {0}, one},
                 {0, Path::Rotation, Interpolation::Linear, {0}, one},
                 {0, Path::Scale, Interpolation::Linear, {kInfinity}, one}}}};
    const Warnings warnings = repair(c);
    CHECK(count(warnings, WarningCode::JointUnused) == 1);
    CHECK(count(warnings, WarningCode::JointNameClash) == 1);
    CHECK(count(warnings, WarningCode::ClipChannelsUnbound) == 1);
    CHECK(count(warnings, WarningCode::ClipValuesNotFinite) == 4);
    CHECK(c.clips[0].channels.size() == 1);
    CHECK(warnings.back().part == "tip");
  }

  TEST_CASE("of keys at one time the last is kept") {
    Character c = strip(1);
    const double soon = 1.0 / 3, a_little_later = soon + 1e-12;  // one float
    Rows values(4, 3), splines(6, 3);
    values.col(0) << 1, 2, 3, 4;
    splines.col(0) << 1, 2, 3, 4, 5, 6;
    c.clips = {{"run",
                {{0, Path::Translation, Interpolation::Linear, {0, soon, a_little_later, 1}, values},
                 {0, Path::Scale, Interpolation::CubicSpline, {2, 2}, splines}}}};
    const Warnings warnings = repair(c);
    CHECK(count(warnings, WarningCode::ClipKeysCoincide) == 2);
    const Channel &line = c.clips[0].channels[0], &spline = c.clips[0].channels[1];
    CHECK(line.times == std::vector<double>{0, a_little_later, 1});
    CHECK(line.values.col(0) == Eigen::Vector3d(1, 3, 4));
    CHECK(spline.times == std::vector<double>{2});
    CHECK(spline.values.col(0) == Eigen::Vector3d(4, 5, 6));
  }

  TEST_CASE("keys out of order are sorted with all their rows and those at one time keep their order") {
    Character c = strip(1);
    Rows values(4, 3), splines(6, 3);
    values.col(0) << 1, 2, 3, 4;
    splines.col(0) << 1, 2, 3, 4, 5, 6;
    c.clips = {{"run",
                {{0, Path::Translation, Interpolation::Linear, {2, 0, 1, 0}, values},
                 {0, Path::Scale, Interpolation::CubicSpline, {1, 0}, splines},
                 {1, Path::Translation, Interpolation::Linear, {0, 1, 2, 3}, values}}}};
    const Warnings warnings = repair(c);
    CHECK(count(warnings, WarningCode::ClipValuesNotFinite) == 0);
    CHECK(count(warnings, WarningCode::ClipKeysUnsorted) == 2);
    CHECK(count(warnings, WarningCode::ClipKeysCoincide) == 1);
    REQUIRE(c.clips[0].channels.size() == 3);
    const Channel &line = c.clips[0].channels[0], &spline = c.clips[0].channels[1];
    CHECK(line.times == std::vector<double>{0, 1, 2});
    CHECK(line.values.col(0) == Eigen::Vector3d(4, 3, 1));
    CHECK(spline.times == std::vector<double>{0, 1});
    CHECK(spline.values.col(0) == (Eigen::VectorXd(6) << 4, 5, 6, 1, 2, 3).finished());
  }

  TEST_CASE("of channels that move the same the first is kept") {
    Character c = strip(1);
    const Rows one = Rows::Constant(1, 3, 1), two = Rows::Constant(1, 3, 2);
    c.clips = {{"run",
                {{0, Path::Translation, Interpolation::Linear, {0}, Rows::Constant(1, 3, kNaN)},
                 {0, Path::Translation, Interpolation::Linear, {0}, one},
                 {0, Path::Scale, Interpolation::Linear, {0}, one},
                 {0, Path::Translation, Interpolation::Linear, {0}, two}}},
               {"walk", {{0, Path::Translation, Interpolation::Linear, {0}, two}}}};
    const Warnings warnings = repair(c);
    CHECK(count(warnings, WarningCode::ClipChannelsTwice) == 1);
    REQUIRE(c.clips[0].channels.size() == 2);
    CHECK(c.clips[0].channels[0].values == one);
    CHECK(c.clips[1].channels.size() == 1);
  }

  TEST_CASE("what nothing can be cooked from is refused with its name") {
    const auto message = [](Character c) -> std::string {
      try {
        repair(c);
      } catch (const Error& e) {
        CHECK(e.fault == Fault::Input);
        return e.what();
      }
      return "";
    };
    Character c = strip(1);
    c.surface.corners.clear(), c.surface.face_begin = {0};
    CHECK(message(c).find("strip: no face") == 0);
    c = strip(1);
    for (Vec3& x : c.surface.position) x *= kNaN;
    CHECK(message(c).find("strip: no face") == 0);
    c = strip(1);
    c.skeleton.joints.clear();
    CHECK(message(c).find("strip: has no joints") == 0);
    c = strip(1);
    c.skeleton.joints[1].inverse_bind(0, 0) = kNaN;
    CHECK(message(c).find("joint 'tip'") != std::string::npos);
    c = strip(1);
    c.skeleton.joints[1].node = 44;
    CHECK(message(c).find("joint") != std::string::npos);
    c = strip(1);
    c.skeleton.nodes[1].rest.scale.y() = kInfinity;
    CHECK(message(c).find("node 'tip'") != std::string::npos);
    c = strip(1);
    c.skeleton.nodes[0].parent = 1;
    CHECK(message(c).find("its own ancestor") != std::string::npos);
  }

  TEST_CASE("random rubbish is repaired or refused and never more") {
    std::mt19937 random(7);
    const auto rubbish = [&] {
      const std::array<double, 8> values = {0, -0.0, 1, -1, kNaN, kInfinity, -1e300, 1e-320};
      return values[random() % 8];
    };
    int cooked = 0;
    for (int trial = 0; trial < 300; ++trial) {
      CAPTURE(trial);
      Character c = strip(6);
      Surface& s = c.surface;
      s.layout = {.normal = true, .uv_sets = 1};
      s.attributes = default_attributes(s.layout).replicate(Eigen::Index(s.wedges.size()), 1);
      for (int i = 0; i < 20; ++i) {
        const size_t v = random() % s.position.size();
        switch (random() % 6) {
          case 0:
            s.position[v][int(random() % 3)] = rubbish();
            break;
          case 1:
            s.influences[v].push_back({int(random() % 5) - 1, rubbish()});
            break;
          case 2:
            s.corners[random() % s.corners.size()] = int(random() % 20) - 2;
            break;
          case 3:
            s.attributes(Eigen::Index(v), Eigen::Index(random() % 5)) = rubbish();
            break;
          case 4:
            s.wedges[v] = {int(random() % 20) - 2, int(random() % 4) - 1};
            break;
          case 5:
            s.influences[v].clear();
            break;
        }
      }
      try {
        repair(c);
        check_repaired(c);
        weld(c);
        check_repaired(c);
        ++cooked;
      } catch (const Error& e) {
        CHECK(e.fault == Fault::Input);
      }
    }
    CHECK(cooked > 150);
  }
}

TEST_SUITE("weld") {
  TEST_CASE("an exploded surface comes back as it was") {
    const Character truth = bending_tube(12, 10, 4);
    Character c = truth;
    c.surface = exploded(truth.surface);
    REQUIRE(c.surface.position.size() == c.surface.corners.size());
    CHECK(repair(c).empty());
    CHECK(weld(c).empty());
    CHECK(c.surface.position.size() == truth.surface.position.size());
    CHECK(c.surface.wedges.size() == truth.surface.wedges.size());
    REQUIRE(c.surface.face_count() == truth.surface.face_count());
    for (size_t i = 0; i < truth.surface.corners.size(); ++i) {
      const int a = c.surface.corners[i], b = truth.surface.corners[i];
      CHECK(c.surface.position[size_t(c.surface.wedges[size_t(a)].vertex)] ==
            truth.surface.position[size_t(truth.surface.wedges[size_t(b)].vertex)]);
      CHECK((c.surface.attributes.row(a) - truth.surface.attributes.row(b)).norm() < 1e-15);
    }
    // The first corner of the first face is the first vertex and wedge.
    CHECK(c.surface.corners[0] == 0);
    CHECK(c.surface.wedges[0].vertex == 0);

    // Once more changes nothing.
    const Character once = c;
    CHECK(weld(c).empty());
    CHECK(c.surface.corners == once.surface.corners);
    CHECK(c.surface.position == once.surface.position);
  }

  TEST_CASE("loose vertices and wedges are dropped") {
    Character c = strip(2);
    Surface& s = c.surface;
    s.position.insert(s.position.begin(), Vec3(5, 5, 5));
    s.influences.insert(s.influences.begin(), {{0, 1}});
    for (Wedge& wedge : s.wedges) ++wedge.vertex;
    s.wedges.push_back({0, 1});
    s.attributes.resize(Eigen::Index(s.wedges.size()), 0);
    CHECK(weld(c).empty());
    CHECK(s.position.size() == 6);
    CHECK(s.wedges.size() == 6);
    CHECK(s.attributes.rows() == 6);
    CHECK(s.position[0] == Vec3(0, 0, 0));
  }

  TEST_CASE("parts meet in one vertex with a wedge each") {
    Character c = strip(1);
    Surface& s = c.surface;
    const int a = add_vertex(s, {-0.0, 0, 0}, {{0, 0.25}, {1, 0.75}}, 1);  // -0 is 0
    const int b = add_vertex(s, {0, 1, 0}, {{0, 0.25}, {1, 0.75}}, 1);
    s.add_face(std::array{b, add_vertex(s, {-1, 0, 0}, {{0, 1}}, 1), a});
    CHECK(weld(c).empty());
    CHECK(s.position.size() == 5);
    CHECK(s.wedges.size() == 7);
    CHECK(s.wedges[size_t(s.face(1)[2])].vertex == 0);
    CHECK(s.part(1) == 1);
  }

  TEST_CASE("positions that differ in the last bits of a double are one") {
    std::mt19937 random(4);
    const auto noise = [&] { return uniform(random, -2e-16, 2e-16); };
    Character c = strip(1);
    c.surface = {};
    Surface& s = c.surface;
    const int n = 3000;
    for (int i = 0; i < n; ++i) {  // round numbers: zero, powers of two, all that floats of 24 bits are
      const std::array<double, 6> round = {
          0, 1, 0.5, 1.5, double(float(uniform(random, -1, 1))), double(float(uniform(random, -1e-3, 1e-3)))};
      const Vec3 x(2 * i, round[random() % 6], round[random() % 6]);
      for (const int part : {0, 1}) {
        const auto corner = [&](const Vec3& y) {
          const Vec3 moved = part ? y + y.cwiseAbs().maxCoeff() * Vec3(noise(), noise(), noise()) : y;
          s.position.push_back(moved);
          s.influences.push_back({{0, 1}});
          s.wedges.push_back({int(s.wedges.size()), part});
          return int(s.wedges.size()) - 1;
        };
        const int a = corner(x), b = corner(x + Vec3(1, 0, 0));
        s.add_face(std::array{a, b, corner(x + Vec3(0.5, 2, 0))});
      }
    }
    s.attributes.resize(Eigen::Index(s.wedges.size()), 0);
    CHECK(weld(c).empty());
    CHECK(s.position.size() == 3 * n);
    CHECK(s.wedges.size() == 6 * n);
  }

  TEST_CASE("positions that a float can tell apart are not joined") {
    Character c = strip(1);
    Surface& s = c.surface;
    const double next = double(std::nextafter(1.0f, 2.0f));
    const int a = add_vertex(s, {next, 0, 0}, s.influences[2]);
    s.add_face(std::array{a, add_vertex(s, {3, 0, 0}, {{0, 1}}), add_vertex(s, {3, 1, 0}, {{0, 1}})});
    CHECK(weld(c).empty());
    CHECK(s.position.size() == 7);
  }

  TEST_CASE("weights that differ by rounding are joined and those that differ by more are kept apart") {
    const auto joined = [](const Influences& other) {
      Character c = strip(1);
      Surface& s = c.surface;
      const int a = add_vertex(s, {1, 0, 0}, other, 1);
      s.add_face(std::array{a, add_vertex(s, {3, 0, 0}, {{0, 1}}, 1), add_vertex(s, {3, 1, 0}, {{0, 1}}, 1)});
      const Warnings warnings = weld(c);
      const bool one = s.position.size() == 6;
      CHECK(s.influences[2] == Influences{{0, 0.25}, {1, 0.75}});
      CHECK(count(warnings, WarningCode::PartsCoincide) == (one ? 0 : 1));
      CHECK(count(warnings, WarningCode::WeightsNearlyEqual) == (one && other != s.influences[2] ? 1 : 0));
      if (!warnings.empty()) CHECK(warnings[0].part == "buckle");
      return one;
    };
    CHECK(joined({{0, 0.25}, {1, 0.75}}));
    CHECK(joined({{0, 0.25005}, {1, 0.74995}}));
    CHECK(!joined({{0, 0.2502}, {1, 0.7498}}));
    CHECK(!joined({{1, 1}}));
  }

  TEST_CASE("morph offsets keep vertices apart and normal offsets keep wedges apart") {
    Character c = strip(1);
    c.morphs = {{"smile", 2}};
    Surface& s = c.surface;
    s.morphs.resize(4);
    s.morphs[2] = {{0, Vec3(0, 0, 1)}};
    const int a = add_vertex(s, s.position[2], s.influences[2]),
              b = add_vertex(s, s.position[3], s.influences[3]);
    s.add_face(std::array{a, add_vertex(s, {2, 0, 0}, {{0, 1}}), b});
    s.normal_morphs.resize(s.wedges.size());
    s.normal_morphs[3] = {{0, Vec3(0, 1, 0)}};
    const Warnings warnings = weld(c);
    CHECK(count(warnings, WarningCode::PartsCoincide) == 1);
    CHECK(s.position.size() == 6);
    CHECK(s.wedges.size() == 7);
    CHECK(s.normal_morphs.size() == 7);
    CHECK(s.morphs[2].size() == 1);
  }

  TEST_CASE("faces that are there twice in a part go and those of another side or part stay") {
    Character c = strip(1);
    Surface& s = c.surface;
    const Influences all = s.influences[0];
    s.add_face(std::array{2, 3, 1, 0});  // the same turn from another corner
    s.add_face(std::array{1, 3, 2, 0});  // the back
    std::vector<int> copy, other;
    for (const int w : {0, 2, 3, 1}) copy.push_back(add_vertex(s, s.position[size_t(w)], all));
    for (const int w : {0, 2, 3, 1}) other.push_back(add_vertex(s, s.position[size_t(w)], all, 1));
    s.add_face(copy);
    s.add_face(other);
    const Warnings warnings = weld(c);
    CHECK(count(warnings, WarningCode::FaceDuplicate) == 2);
    CHECK(s.face_count() == 3);
    CHECK(s.position.size() == 4);
    CHECK(count(warnings, WarningCode::NonManifoldEdges) == 4);
  }

  TEST_CASE("a doubled corner makes a quad a triangle and a triangle nothing") {
    Character c = strip(2);
    Surface& s = c.surface;
    const int copy = add_vertex(s, s.position[0], s.influences[0]);
    s.add_face(std::array{0, 2, 5, copy});
    s.add_face(std::array{0, copy, 3});
    s.add_face(std::array{1, 0, 3, 0, 2});  // touches itself
    const Warnings warnings = weld(c);
    REQUIRE(s.face_count() == 3);
    CHECK(s.face(2).size() == 3);
    CHECK(count(warnings, WarningCode::FaceDegenerate) == 3);
    CHECK(triangle_count(s) == 5);
  }

  TEST_CASE("nothing that coincides comes apart in any pose") {
    std::mt19937 random(5);
    const Character truth = bending_tube(12, 10, 4);
    Character c = truth;
    c.surface = exploded(truth.surface);
    for (Influences& influences : c.surface.influences) {
      for (Influence& i : influences) i.weight *= uniform(random, 1 - 1e-5, 1 + 1e-5);
      if (random() % 2) std::reverse(influences.begin(), influences.end());
    }
    repair(c);
    const Warnings warnings = weld(c);
    CHECK(c.surface.position.size() == truth.surface.position.size());
    CHECK(count(warnings, WarningCode::WeightsNearlyEqual) > 0);
    CHECK(count(warnings, WarningCode::PartsCoincide) == 0);
    const auto posed = pose_vertices(c.surface, sample(c.skeleton, c.clips[0], 1));
    const auto wanted = pose_vertices(truth.surface, sample(c.skeleton, c.clips[0], 1));
    for (size_t i = 0; i < c.surface.corners.size(); ++i) {
      const size_t a = size_t(c.surface.wedges[size_t(c.surface.corners[i])].vertex);
      const size_t b = size_t(truth.surface.wedges[size_t(truth.surface.corners[i])].vertex);
      CHECK((posed[a] - wanted[b]).norm() < 1e-3);
    }
  }

  TEST_CASE("a hundred thousand different vertices at one place are no trouble") {
    std::mt19937 random(9);
    Character c = strip(1);
    Surface& s = c.surface;
    const int n = 100000;
    for (int i = 0; i < n; ++i) {
      const double w = uniform(random, 0, 1);
      s.position.push_back(Vec3(1, 0, 0));
      s.influences.push_back({{0, w}, {1, 1 - w}});
      s.wedges.push_back({4 + i, 0});
      s.add_face(std::array{0, 4 + i, 3});
    }
    s.attributes.resize(Eigen::Index(s.wedges.size()), 0);
    const Warnings warnings = weld(c);
    CHECK(s.position.size() > 90000);
    CHECK(count(warnings, WarningCode::PartsCoincide) == std::int64_t(s.position.size()) - 4);
    CHECK(count(warnings, WarningCode::FaceDuplicate) > 0);  // of those that were joined
  }

  TEST_CASE("without attributes only points and influences and faces are left") {
    const Surface s = bending_tube(12, 8, 3).surface;
    REQUIRE(s.wedges.size() > s.position.size());
    const Surface bare = without_attributes(s);
    CHECK(bare.position == s.position);
    CHECK(bare.influences == s.influences);
    CHECK(bare.wedges.size() == s.position.size());
    CHECK(bare.attributes.cols() == 0);
    REQUIRE(bare.face_count() == s.face_count());
    for (size_t i = 0; i < s.corners.size(); ++i)
      CHECK(bare.wedges[bare.corners[i]].vertex == s.wedges[s.corners[i]].vertex);
  }

  TEST_CASE("without attributes parts and morphs keep nothing apart but influences do") {
    Character c = strip(1);
    Surface& s = c.surface;
    s.morphs.assign(4, {});
    const auto beside = [&](const Influences influences) {
      const int a = add_vertex(s, s.position[2], influences, 1),
                b = add_vertex(s, s.position[3], influences, 1);
      const int far = add_vertex(s, Vec3(2, 0, 0), influences, 1);
      s.morphs[size_t(a)] = {{0, Vec3(0, 0, 1)}};
      s.add_face(std::array{a, far, b});
    };
    beside(s.influences[0]);
    CHECK(without_attributes(s).position.size() == 5);
    beside({{0, 1.0}});
    CHECK(without_attributes(s).position.size() == 8);
    CHECK(without_attributes(s).morphs.empty());
  }
}
