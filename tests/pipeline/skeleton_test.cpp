// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <numbers>
#include <random>

#include "pipeline/error.h"
#include "pipeline/rotation.h"
#include "pipeline/skeleton.h"
#include "tests/random.h"

using namespace skinlod;

namespace {

Transform random_transform(std::mt19937& random) {
  return {random_vector(random, 2), turn(random_vector(random, 3)),
          Vec3(uniform(random, 0.5, 2), uniform(random, 0.5, 2), uniform(random, 0.5, 2))};
}

Affine moved(const Vec3& by) {
  Affine a = identity();
  a.col(3) = by;
  return a;
}

// A root with `count` nodes in a chain below it, each with a random rest transform.
Skeleton random_chain(std::mt19937& random, int count) {
  Skeleton skeleton;
  for (int n = 0; n < count; ++n) {
    skeleton.nodes.push_back(
        {.name = "n" + std::to_string(n), .parent = n - 1, .rest = random_transform(random)});
  }
  return skeleton;
}

std::vector<Affine> random_globals(const Skeleton& skeleton, std::mt19937& random) {
  std::vector<Affine> locals;
  for (size_t n = 0; n < skeleton.nodes.size(); ++n) locals.push_back(affine(random_transform(random)));
  return globals(skeleton, locals);
}

double difference(const Affine& a, const Affine& b) { return (a - b).cwiseAbs().maxCoeff(); }

}  // namespace

TEST_SUITE("skeleton") {
  TEST_CASE("a transform scales and then turns and then moves") {
    const Transform t{Vec3(10, 0, 0), turn(Vec3(0, 0, 1), std::numbers::pi / 2), Vec3(2, 3, 4)};
    CHECK((transform(affine(t), Vec3(1, 1, 1)) - Vec3(7, 2, 4)).norm() < 1e-14);
    const Transform doubled{Vec3::Zero(), Quat(0, 0, 0, 2), Vec3::Ones()};
    CHECK(affine(doubled) == identity());
  }

  TEST_CASE("a matrix without shear is decomposed exactly") {
    std::mt19937 random(1);
    for (int i = 0; i < 500; ++i) {
      Transform t = random_transform(random);
      if (i % 2) t.scale[i % 3] *= -1;
      if (i % 5 == 0) t.scale *= -1;
      const Affine a = affine(t);
      CAPTURE(i);
      const Transform back = decompose(a);
      CHECK(difference(affine(back), a) < 1e-14);
      CHECK((back.scale.array() < 0).count() == (t.scale.prod() < 0 ? 1 : 0));
    }
  }

  TEST_CASE("a matrix with zero scales is decomposed into a rotation and those scales") {
    std::mt19937 random(2);
    for (int zeros = 1; zeros < 8; ++zeros) {
      Transform t = random_transform(random);
      for (int i = 0; i < 3; ++i) {
        if (zeros >> i & 1) t.scale[i] = 0;
      }
      CAPTURE(zeros);
      const Transform back = decompose(affine(t));
      CHECK(difference(affine(back), affine(t)) < 1e-14);
      CHECK(back.rotation.norm() == doctest::Approx(1).epsilon(1e-14));
      CHECK((matrix(back.rotation).transpose() * matrix(back.rotation) - Mat3::Identity()).norm() < 1e-14);
    }
  }

  TEST_CASE("parents come first in any order of the file") {
    Skeleton skeleton;
    for (const int parent : {3, 0, -1, 2, 1, 0}) skeleton.nodes.push_back({.name = "n", .parent = parent});
    const std::vector<int> order = parents_first(skeleton);
    REQUIRE(order.size() == 6);
    std::vector<int> place(6, -1);
    for (int i = 0; i < 6; ++i) place[size_t(order[size_t(i)])] = i;
    for (int n = 0; n < 6; ++n) {
      CHECK(place[size_t(n)] >= 0);
      if (const int parent = skeleton.nodes[size_t(n)].parent; parent >= 0) {
        CHECK(place[size_t(parent)] < place[size_t(n)]);
      }
    }
  }

  TEST_CASE("nodes in a circle and parents out of range are refused") {
    Skeleton circle;
    for (const int parent : {-1, 3, 1, 2}) circle.nodes.push_back({.name = "n", .parent = parent});
    CHECK_THROWS_AS(parents_first(circle), Error);
    Skeleton own{.nodes = {{.name = "n", .parent = 0}}, .joints = {}};
    CHECK_THROWS_AS(parents_first(own), Error);
    Skeleton outside{.nodes = {{.name = "n", .parent = 1}}, .joints = {}};
    CHECK_THROWS_AS(parents_first(outside), Error);
    outside.nodes[0].parent = -2;
    CHECK_THROWS_AS(parents_first(outside), Error);
  }

  TEST_CASE("a very long chain of nodes is no trouble") {
    Skeleton skeleton;
    const int count = 200000;
    for (int n = 0; n < count; ++n)
      skeleton.nodes.push_back({.name = "", .parent = n + 1 < count ? n + 1 : -1});
    const std::vector<int> order = parents_first(skeleton);
    CHECK(order.front() == count - 1);
    CHECK(order.back() == 0);
  }

  TEST_CASE("globals stack the locals from the root down") {
    Skeleton skeleton;
    skeleton.nodes = {{.name = "child", .parent = 1, .rest = {.translation = Vec3(1, 0, 0)}},
                      {.name = "root", .rest = {.rotation = turn(Vec3(0, 0, 1), std::numbers::pi / 2)}}};
    const std::vector<Affine> global = globals(skeleton, rest_locals(skeleton));
    CHECK((transform(global[0], Vec3(1, 0, 0)) - Vec3(0, 2, 0)).norm() < 1e-14);

    Affine shear = identity();
    shear(0, 1) = 1;
    skeleton.nodes[1].matrix = shear;
    CHECK((transform(globals(skeleton, rest_locals(skeleton))[0], Vec3(0, 1, 0)) - Vec3(2, 1, 0)).norm() <
          1e-14);
  }

  TEST_CASE("at rest the palette of an added skin is the identity") {
    std::mt19937 random(3);
    Skeleton skeleton = random_chain(random, 6);
    const std::vector<Affine> rest = globals(skeleton, rest_locals(skeleton));
    const Affine bind_space = affine(random_transform(random));  // any: centimetres, another axis
    std::vector<Joint> skin;
    for (const int n : {4, 2, 3}) skin.push_back({n, compose(inverse(rest[size_t(n)]), bind_space)});
    const BoundSkin bound = add_skin(skeleton, skin);
    CHECK(difference(bound.to_rest, bind_space) < 1e-12);
    CHECK(bound.joint == std::vector{0, 1, 2});
    for (const Affine& T : palette(skeleton, rest)) CHECK(difference(T, identity()) < 1e-12);
  }

  TEST_CASE("added skins put every point where the file puts it in every pose") {
    std::mt19937 random(4);
    for (int trial = 0; trial < 50; ++trial) {
      CAPTURE(trial);
      Skeleton skeleton = random_chain(random, 8);
      std::vector<std::vector<Joint>> skins(4);
      for (auto& skin : skins) {  // binds that have nothing to do with the rest pose or with each other
        for (int n = int(random() % 4); n < 8; n += 1 + int(random() % 3)) {
          skin.push_back({n, affine(random_transform(random))});
        }
      }
      skins.push_back({{5, identity()}});
      std::vector<BoundSkin> bound;
      for (const auto& skin : skins) bound.push_back(add_skin(skeleton, skin));

      const std::vector<Affine> global = random_globals(skeleton, random);
      const Palette T = palette(skeleton, global);
      for (size_t s = 0; s < skins.size(); ++s) {
        for (size_t i = 0; i < skins[s].size(); ++i) {
          const Vec3 x = random_vector(random, 1);
          const Vec3 truth =
              transform(global[size_t(skins[s][i].node)], transform(skins[s][i].inverse_bind, x));
          const Vec3 ours = transform(T[size_t(bound[s].joint[i])], transform(bound[s].to_rest, x));
          CHECK((ours - truth).norm() < 1e-9 * (1 + truth.norm()));
        }
      }
    }
  }

  TEST_CASE("skins of one skeleton share their joints although each binds in a space of its own") {
    std::mt19937 random(5);
    Skeleton skeleton = random_chain(random, 6);
    // The bind pose is not the rest pose, and the second skin does not have the first one's root.
    const std::vector<Affine> bind = random_globals(skeleton, random);
    const auto skin = [&](const std::vector<int>& nodes, const Affine& space) {
      std::vector<Joint> joints;
      for (const int n : nodes) joints.push_back({n, compose(inverse(bind[size_t(n)]), space)});
      return joints;
    };
    const Affine centimetres = affine({.scale = Vec3::Constant(0.01)});
    const BoundSkin body = add_skin(skeleton, skin({1, 2, 3, 4}, identity()));
    const BoundSkin head = add_skin(skeleton, skin({4, 3, 5}, centimetres));
    CHECK(skeleton.joints.size() == 5);
    CHECK(head.joint == std::vector{3, 2, 4});
    const Vec3 x(0.3, 0.2, 0.1);
    CHECK((transform(body.to_rest, x) - transform(head.to_rest, 100 * x)).norm() < 1e-9);
  }

  TEST_CASE("a rigid prop shares the joint it hangs on") {
    std::mt19937 random(6);
    Skeleton skeleton = random_chain(random, 4);
    const std::vector<Affine> bind = random_globals(skeleton, random);
    std::vector<Joint> skin;
    for (const int n : {1, 2, 3}) skin.push_back({n, inverse(bind[size_t(n)])});
    const BoundSkin body = add_skin(skeleton, skin);
    const BoundSkin sword = add_skin(skeleton, std::vector<Joint>{{3, identity()}});
    CHECK(skeleton.joints.size() == 3);
    CHECK(sword.joint == std::vector{body.joint[2]});
    // It stands in the bound hand, not in the hand of the rest pose.
    CHECK(difference(sword.to_rest, compose(body.to_rest, bind[3])) < 1e-9);
  }

  TEST_CASE("a rigid prop on a node below a joint hangs from it by the rest pose") {
    Skeleton skeleton;
    skeleton.nodes = {{.name = "hand", .rest = {.translation = Vec3(1, 0, 0)}},
                      {.name = "slot", .parent = 0, .rest = {.translation = Vec3(0, 0.5, 0)}}};
    add_skin(skeleton, std::vector<Joint>{{0, moved(Vec3(-1, 0, 0))}});
    const BoundSkin prop = add_skin(skeleton, std::vector<Joint>{{1, identity()}});
    CHECK(difference(prop.to_rest, moved(Vec3(1, 0.5, 0))) < 1e-15);
    CHECK(skeleton.joints.size() == 2);
  }

  TEST_CASE("one node bound in two places is two joints") {
    Skeleton skeleton{.nodes = {{.name = "a"}, {.name = "b", .parent = 0}}, .joints = {}};
    add_skin(skeleton, std::vector<Joint>{{0, identity()}, {1, identity()}});
    const BoundSkin other =
        add_skin(skeleton, std::vector<Joint>{{0, identity()}, {1, moved(Vec3(0, 1, 0))}});
    CHECK(other.joint == std::vector{0, 2});
    CHECK(skeleton.joints[2].node == 1);
  }

  TEST_CASE("the joint nearest to the root places a skin and ties go to the first") {
    Skeleton skeleton;
    skeleton.nodes = {{.name = "root"},
                      {.name = "deep", .parent = 3},
                      {.name = "left", .parent = 0, .rest = {.translation = Vec3(1, 0, 0)}},
                      {.name = "right", .parent = 0, .rest = {.translation = Vec3(0, 1, 0)}}};
    const std::vector<Joint> skin = {{1, moved(Vec3(7, 0, 0))}, {3, moved(Vec3(0, 0, 5))}, {2, identity()}};
    CHECK(add_skin(skeleton, skin).to_rest == moved(Vec3(0, 1, 5)));
  }

  TEST_CASE("a prop hidden by a zero scale at rest still gets a rest space it can leave") {
    Skeleton skeleton;
    skeleton.nodes = {{.name = "hand", .rest = {.translation = Vec3(1, 2, 3)}},
                      {.name = "prop", .parent = 0, .rest = {.scale = Vec3::Zero()}}};
    const BoundSkin prop = add_skin(skeleton, std::vector<Joint>{{1, identity()}});
    CHECK(invertible(prop.to_rest));
    CHECK(difference(prop.to_rest, moved(Vec3(1, 2, 3))) < 1e-15);
    // Shown at scale 2, it stands where the file puts it.
    std::vector<Affine> locals = rest_locals(skeleton);
    locals[1] = affine({.scale = Vec3::Constant(2)});
    const Palette T = palette(skeleton, globals(skeleton, locals));
    CHECK((transform(T[0], transform(prop.to_rest, Vec3(1, 0, 0))) - Vec3(3, 2, 3)).norm() < 1e-12);
    CHECK(palette(skeleton, globals(skeleton, rest_locals(skeleton)))[0].allFinite());
  }

  TEST_CASE("singular binds do not place a skin and an all singular skin stays where it is") {
    Skeleton skeleton{.nodes = {{.name = "a"}, {.name = "b", .parent = 0}}, .joints = {}};
    const std::vector<Joint> half = {{0, Affine::Zero()}, {1, moved(Vec3(0, 4, 0))}};
    CHECK(add_skin(skeleton, half).to_rest == moved(Vec3(0, 4, 0)));
    CHECK(add_skin(skeleton, std::vector<Joint>{{0, Affine::Zero()}}).to_rest == identity());
    for (const Joint& joint : skeleton.joints) CHECK(joint.inverse_bind.allFinite());
  }
}
