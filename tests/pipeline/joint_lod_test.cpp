// SPDX-License-Identifier: MIT
#include "pipeline/joint_lod.h"

#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/chain.h"
#include "pipeline/error.h"
#include "pipeline/metrics/articulated.h"
#include "pipeline/metrics/surface_quadrics.h"
#include "pipeline/parallel.h"
#include "tests/shapes.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

PoseSet eight_poses(const Character& c) {
  return choose_poses(
      c, {.from_clips = 5, .range_of_motion = 3, .unseen_clip_frames = 3, .unseen_range_of_motion = 1});
}

// The tube of six joints, of which the fourth moves with the third.
Character with_a_still_joint() {
  Character c = bending_tube(16, 36, 6);
  for (Clip& clip : c.clips) std::erase_if(clip.channels, [](const Channel& its) { return its.node == 3; });
  return c;
}

bool follows(const Surface& surface, int joint) {
  return std::any_of(surface.influences.begin(), surface.influences.end(), [&](const Influences& influences) {
    return std::any_of(influences.begin(), influences.end(),
                       [&](const Influence& i) { return i.joint == joint; });
  });
}

// A small tube whose vertices follow three of four joints each, in poses that part them.
struct Small {
  Character c = bending_tube(6, 5, 4);
  std::vector<Pose> poses = {{"bind", Palette(4, identity())}};

  Small() {
    for (size_t v = 0; v < c.surface.influences.size(); ++v) {
      c.surface.influences[v] = {{0, 0.5}, {1, 0.2}, {2, 0.2}, {3, 0.1}};
      c.surface.influences[v].erase(c.surface.influences[v].begin() + int(v % 4));
      double sum = 0;
      for (const Influence& i : c.surface.influences[v]) sum += i.weight;
      for (Influence& i : c.surface.influences[v]) i.weight /= sum;
    }
    for (unsigned p = 1; p < 6; ++p) poses.push_back({"random", random_palette(4, p, 0.5, 0.2)});
  }
};

// The least that weights >= 0 of sum 1 over `joints` make of the posed quadrics at `x`, over all sets of
// them: within a set of those above 0 it is a system of linear equations.
double least(const std::vector<std::vector<Quadric>>& quadrics, int v, const Vec3& x,
             std::span<const Pose> poses, const std::vector<int>& joints) {
  double best = std::numeric_limits<double>::infinity();
  for (unsigned set = 1; set < 1u << joints.size(); ++set) {
    std::vector<int> some;
    for (size_t k = 0; k < joints.size(); ++k) {
      if (set >> k & 1) some.push_back(joints[k]);
    }
    const auto n = Eigen::Index(some.size());
    MatX A = MatX::Zero(n + 1, n + 1);
    VecX b = VecX::Zero(n + 1);
    const auto posed = [&](size_t p, Eigen::Index k) { return transform(poses[p].palette[some[k]], x); };
    for (size_t p = 0; p < poses.size(); ++p) {
      for (Eigen::Index i = 0; i < n; ++i) {
        for (Eigen::Index j = 0; j < n; ++j) A(i, j) += posed(p, i).dot(quadrics[p][v].A * posed(p, j));
        b[i] -= quadrics[p][v].b.dot(posed(p, i));
      }
    }
    A.col(n).head(n).setOnes(), A.row(n).head(n).setOnes(), b[n] = 1;
    const VecX w = A.fullPivLu().solve(b).head(n);
    if (w.minCoeff() < 0) continue;
    double sum = 0;
    for (size_t p = 0; p < poses.size(); ++p) {
      Vec3 at = Vec3::Zero();
      for (Eigen::Index k = 0; k < n; ++k) at += w[k] * posed(p, k);
      sum += quadrics[p][v](at);
    }
    best = std::min(best, sum);
  }
  return best;
}

}  // namespace

TEST_SUITE("joint_lod") {
  TEST_CASE("the joint that moves like another leaves first and costs nothing") {
    const Character still = with_a_still_joint(), moving = bending_tube(16, 36, 6);
    const std::vector<LevelTarget> targets = {{.ratio = 0.5, .max_joints = 5}};
    const Chain chain = build_chain(still, eight_poses(still), {.targets = targets});
    const double size = diagonal(still.surface.position);
    REQUIRE(chain.levels[1].joints_left.size() == 1);
    CHECK(chain.levels[1].joints_left[0].joint == 3);
    CHECK(chain.levels[1].joints_left[0].cost < 1e-6 * size);
    CHECK(chain.levels[1].joints == 5);
    CHECK(chain.levels[1].reached);
    const Chain with_all = build_chain(still, eight_poses(still), {.targets = {{.ratio = 0.5}}});
    CHECK(with_all.levels[1].joints == 6);
    CHECK(with_all.levels[1].joints_left.empty());
    CHECK(chain.levels[1].examples.rms < 1.01 * with_all.levels[1].examples.rms);

    const Chain control = build_chain(moving, eight_poses(moving), {.targets = targets});
    REQUIRE(control.levels[1].joints_left.size() == 1);
    CHECK(control.levels[1].joints_left[0].cost > 1e-3 * size);
  }

  TEST_CASE("of two joints that move alike the deeper one leaves") {
    // Where the third alone is turned the fourth to the sixth follow it.
    Character c = bending_tube(16, 36, 6);
    for (Clip& clip : c.clips) std::erase_if(clip.channels, [](const Channel& its) { return its.node > 2; });
    const Chain chain = build_chain(c, eight_poses(c), {.targets = {{.ratio = 0.5, .max_joints = 3}}});
    std::vector<int> left;
    for (const LeftJoint& its : chain.levels[1].joints_left) left.push_back(its.joint);
    CHECK(left == std::vector<int>{5, 4, 3});
  }

  TEST_CASE("a joint that must stay does so whatever it costs the others") {
    const Character c = with_a_still_joint();
    const std::vector<LevelTarget> targets = {{.ratio = 0.5, .max_joints = 5},
                                              {.ratio = 0.2, .max_joints = 2}};
    const Chain free = build_chain(c, eight_poses(c), {.targets = targets});
    const Chain held = build_chain(c, eight_poses(c), {.targets = targets, .keep_joints = {"joint3"}});
    CHECK_FALSE(follows(free.levels[1].surface, 3));
    for (const Level& level : held.levels) {
      CHECK(follows(level.surface, 3));
      CHECK(level.reached);
    }
    CHECK(held.levels[2].joints == 2);
  }

  TEST_CASE("joints that must stay are counted where they are too many") {
    const Character c = bending_tube(16, 36, 6);
    const Chain chain = build_chain(
        c, eight_poses(c), {.targets = {{.ratio = 0.5, .max_joints = 3}}, .keep_joints = {"joint?"}});
    CHECK(chain.levels[1].joints == 6);
    CHECK_FALSE(chain.levels[1].reached);
    CHECK(chain.levels[1].reason == "6 joints are left and must stay: allow more, or keep fewer");
  }

  TEST_CASE("a joint that left is in no coarser level and weights stay what GPUs need") {
    const Character c = bending_tube(16, 48, 8);
    const Chain chain = build_chain(c, eight_poses(c),
                                    {.targets = {{.ratio = 0.5, .max_influences = 4, .max_joints = 6},
                                                 {.ratio = 0.25, .max_influences = 3, .max_joints = 4},
                                                 {.ratio = 0.1, .max_influences = 2, .max_joints = 2}}});
    std::vector<int> gone;
    for (size_t l = 0; l < chain.levels.size(); ++l) {
      CAPTURE(l);
      const Level& level = chain.levels[l];
      CHECK(level.joints == 8 - 2 * int(l));
      CHECK(level.joints == joint_count(level.surface));
      CHECK(level.joints_left.size() == (l == 0 ? 0 : 2));
      for (const LeftJoint& its : level.joints_left) gone.push_back(its.joint);
      for (const int joint : gone) CHECK_FALSE(follows(level.surface, joint));
      for (const Influences& influences : level.surface.influences) {
        double sum = 0;
        for (const Influence& i : influences) {
          CHECK(i.weight > 0);
          sum += i.weight;
        }
        CHECK(sum == doctest::Approx(1).epsilon(1e-9));
        CHECK(int(influences.size()) <= level.max_influences);
      }
    }
    CHECK(gone.size() == 6);
  }

  TEST_CASE("what leaves is the cheapest of all and costs what enumeration finds") {
    const Small small;
    const Surface& s = small.c.surface;
    const Mesh mesh(s);
    std::vector<std::vector<Quadric>> quadrics;
    double weight = 0;
    for (const Pose& pose : small.poses) {
      quadrics.push_back(surface_quadrics(mesh, pose_vertices(s, pose.palette), held_lines(mesh)));
      for (const Quadric& q : quadrics.back()) weight += q.A.trace();
    }
    std::vector<double> cost(4, 0);
    for (int b = 0; b < 4; ++b) {
      std::vector<int> others = {0, 1, 2, 3};
      std::erase(others, b);
      for (int v = 0; v < mesh.vertex_count(); ++v) {
        const Influences& its = s.influences[size_t(v)];
        if (std::none_of(its.begin(), its.end(), [&](const Influence& i) { return i.joint == b; })) continue;
        cost[size_t(b)] += least(quadrics, v, s.position[size_t(v)], small.poses, others);
      }
    }
    ArticulatedMetric metric(mesh, s.influences, small.poses);
    JointLod joints(small.c.skeleton, small.poses, std::vector<bool>(4, false), diagonal(s.position));
    const auto left = metric.let_leave(mesh, joints, {.count = 3}).joints;
    REQUIRE(left.size() == 1);
    const auto cheapest = std::min_element(cost.begin(), cost.end());
    CHECK(*cheapest > 0);
    CHECK(left[0].joint == int(cheapest - cost.begin()));
    CHECK(left[0].cost == doctest::Approx(std::sqrt(*cheapest / weight)).epsilon(1e-3));
  }

  TEST_CASE("joints leave as long as they may cost something and the measured error rises by less") {
    const Character c = bending_tube(16, 48, 8);
    const double size = diagonal(c.surface.position);
    const Chain with_all = build_chain(c, eight_poses(c), {.targets = {{.ratio = 0.25}}});
    int before = 8;
    for (const double error : {0.002, 0.01, 0.03}) {
      CAPTURE(error);
      const Chain chain =
          build_chain(c, eight_poses(c), {.targets = {{.ratio = 0.25, .joint_error = error}}});
      const Level& level = chain.levels[1];
      double squares = 0;
      for (const LeftJoint& its : level.joints_left) squares += its.cost * its.cost;
      CHECK(std::sqrt(squares) <= error * size);
      CHECK(level.joints == 8 - int(level.joints_left.size()));
      CHECK(level.joints <= before);
      CHECK(level.reached);
      CHECK(level.examples.rms <= with_all.levels[1].examples.rms + error * size);
      before = level.joints;
    }
    CHECK(before < 6);
    CHECK(before > 1);
  }

  TEST_CASE("an error target has what the joints cost in it") {
    const Character c = bending_tube(16, 48, 8);
    const Chain chain = build_chain(c, eight_poses(c), {.targets = {{.max_error = 0.02, .max_joints = 6}}});
    CHECK(chain.levels[1].reached);
    CHECK(chain.levels[1].joints == 6);
    CHECK(chain.levels[1].examples.rms <= 0.02 * diagonal(c.surface.position));
    CHECK(triangle_count(chain.levels[1].surface) < triangle_count(c.surface));
  }

  TEST_CASE("the same joints leave at the same cost for any number of threads") {
    const Character c = bending_tube(16, 48, 8);
    const auto cook = [&](int count) {
      const ThreadLimit threads(count);
      return build_chain(c, eight_poses(c), {.targets = {{.ratio = 0.25, .max_joints = 3}}});
    };
    const Chain one = cook(1), two = cook(2);
    const auto &a = one.levels[1].joints_left, &b = two.levels[1].joints_left;
    REQUIRE(a.size() == 5);
    REQUIRE(b.size() == 5);
    for (size_t i = 0; i < a.size(); ++i) {
      CHECK(a[i].joint == b[i].joint);
      CHECK(a[i].cost == b[i].cost);
    }
    CHECK(one.levels[1].surface.position == two.levels[1].surface.position);
    CHECK(one.levels[1].surface.influences == two.levels[1].surface.influences);
  }

  TEST_CASE("limits that make no sense are refused") {
    const Character c = bending_tube(12, 8, 3);
    const PoseSet poses = eight_poses(c);
    const auto refused = [&](const LevelTarget& target, Metric metric = Metric::Articulated) {
      CHECK_THROWS_AS(build_chain(c, poses, {.targets = {target}, .metric = metric}), Error);
    };
    refused({.ratio = 0.5, .max_joints = 0});
    refused({.ratio = 0.5, .joint_error = 0});
    refused({.ratio = 0.5, .max_joints = 2, .joint_error = 0.1});
    refused({.ratio = 0.5, .max_joints = 2}, Metric::RestPose);
    CHECK_NOTHROW(build_chain(c, poses, {.targets = {{.ratio = 0.5, .max_joints = 99}}}));
  }
}
