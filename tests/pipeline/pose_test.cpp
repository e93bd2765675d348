// SPDX-License-Identifier: MIT
#include "pipeline/pose.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "pipeline/error.h"
#include "pipeline/parallel.h"
#include "pipeline/rotation.h"
#include "tests/random.h"
#include "tests/shapes.h"

using namespace skinlod;

namespace {

using std::numbers::pi;

// One node called "n" that one channel moves.
Skeleton one_node() {
  return {.nodes = {{.name = "n", .rest = {.translation = Vec3(0, 0, 7)}}}, .joints = {}};
}

Clip one_channel(Path path, Interpolation how, std::vector<double> times, const MatX& values) {
  return {.name = "clip", .channels = {{0, path, how, std::move(times), values}}};
}

Vec3 translation_at(const Clip& clip, double time) { return sample_locals(one_node(), clip, time)[0].col(3); }

double rms(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (size_t v = 0; v < a.size(); ++v) sum += (a[v] - b[v]).squaredNorm();
  return std::sqrt(sum / double(a.size()));
}

std::vector<std::string> sources(const std::vector<Pose>& poses) {
  std::vector<std::string> all;
  for (const Pose& pose : poses) all.push_back(pose.source);
  return all;
}

void check_same(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  CHECK(sources(a) == sources(b));
  REQUIRE(a.size() == b.size());
  for (size_t p = 0; p < a.size(); ++p) CHECK(a[p].palette == b[p].palette);
}

// Each joint's rotation relative to its parent in a pose of bending_tube, as a rotation vector.
std::vector<Vec3> turns(const Pose& pose) {
  std::vector<Vec3> all;
  Mat3 parent = Mat3::Identity();
  for (const Affine& T : pose.palette) {
    all.push_back(rotation_vector(quaternion(parent.transpose() * T.leftCols<3>())));
    parent = T.leftCols<3>();
  }
  return all;
}

bool unlike(const std::vector<Pose>& a, const std::vector<Pose>& b, const Surface& surface) {
  for (const Pose& p : a) {
    for (const Pose& q : b) {
      if (&p != &q && rms(pose_vertices(surface, p.palette), pose_vertices(surface, q.palette)) < 1e-6)
        return false;
    }
  }
  return true;
}

}  // namespace

TEST_SUITE("pose") {
  TEST_CASE("a linear channel is held outside its keys and straight between them") {
    MatX values(3, 3);
    values << 0, 0, 0, 2, 4, 6, 2, 0, 0;
    const Clip clip = one_channel(Path::Translation, Interpolation::Linear, {1, 2, 4}, values);
    CHECK(translation_at(clip, -5) == Vec3(0, 0, 0));
    CHECK(translation_at(clip, 1) == Vec3(0, 0, 0));
    CHECK(translation_at(clip, 1.5) == Vec3(1, 2, 3));
    CHECK(translation_at(clip, 2) == Vec3(2, 4, 6));
    CHECK(translation_at(clip, 3) == Vec3(2, 2, 3));
    CHECK(translation_at(clip, 4) == Vec3(2, 0, 0));
    CHECK(translation_at(clip, 100) == Vec3(2, 0, 0));
  }

  TEST_CASE("a step channel keeps each key until the next") {
    MatX values(2, 3);
    values << 1, 1, 1, 2, 2, 2;
    const Clip clip = one_channel(Path::Translation, Interpolation::Step, {0, 1}, values);
    CHECK(translation_at(clip, -1) == Vec3(1, 1, 1));
    CHECK(translation_at(clip, 0.999) == Vec3(1, 1, 1));
    CHECK(translation_at(clip, 1) == Vec3(2, 2, 2));
    CHECK(translation_at(clip, 9) == Vec3(2, 2, 2));
  }

  TEST_CASE("a cubic spline is exact for a cubic with its derivatives as tangents") {
    const auto cubic = [](double t) { return Vec3(t * t * t, 2 * t * t - t, 5 - t); };
    const auto slope = [](double t) { return Vec3(3 * t * t, 4 * t - 1, -1); };
    const std::vector<double> times = {0, 0.5, 2};
    MatX values(9, 3);
    for (int k = 0; k < 3; ++k) {
      values.row(3 * k) = values.row(3 * k + 2) = slope(times[size_t(k)]).transpose();
      values.row(3 * k + 1) = cubic(times[size_t(k)]).transpose();
    }
    const Clip clip = one_channel(Path::Translation, Interpolation::CubicSpline, times, values);
    for (const double t : {0.0, 0.1, 0.4, 0.5, 0.9, 1.7, 2.0}) {
      CAPTURE(t);
      CHECK((translation_at(clip, t) - cubic(t)).norm() < 1e-14);
    }
    CHECK(translation_at(clip, 3) == cubic(2));
  }

  TEST_CASE("rotations are interpolated along the arc and of unit length") {
    MatX values(2, 4);
    values << 0, 0, 0, 1, 0, 0, -std::sin(pi / 4), -std::cos(pi / 4);  // the far cover of a quarter turn
    const Clip clip = one_channel(Path::Rotation, Interpolation::Linear, {0, 1}, values);
    const Affine third = sample_locals(one_node(), clip, 1.0 / 3)[0];
    CHECK((transform(third, Vec3(1, 0, 0)) - Vec3(std::cos(pi / 6), 0.5, 7)).norm() < 1e-14);

    MatX cubic = MatX::Zero(6, 4);
    cubic.row(1) << 0, 0, 0, 2;  // not of unit length: exporters do this
    cubic.row(4) = values.row(1) * -3;
    const Clip smooth = one_channel(Path::Rotation, Interpolation::CubicSpline, {0, 1}, cubic);
    for (const double t : {-1.0, 0.0, 0.3, 0.5, 1.0, 2.0}) {
      const Transform got = sample_transforms(one_node(), smooth, t)[0];
      CHECK(got.rotation.norm() == doctest::Approx(1).epsilon(1e-14));
      CHECK(got.translation == Vec3(0, 0, 7));
    }
  }

  TEST_CASE("nodes that no channel moves keep their rest and their rest matrix") {
    Skeleton skeleton = one_node();
    Affine shear = identity();
    shear(0, 1) = 0.5;
    skeleton.nodes.push_back({.name = "sheared", .parent = 0, .matrix = shear});
    MatX values(1, 3);
    values << 2, 2, 2;
    Clip clip = one_channel(Path::Scale, Interpolation::Linear, {0}, values);
    clip.channels.push_back({1, Path::MorphWeights, Interpolation::Linear, {0}, Rows::Ones(1, 2)});
    clip.channels.push_back({1, Path::Translation, Interpolation::Linear, {}, Rows(0, 3)});
    std::vector<Affine> locals = sample_locals(skeleton, clip, 0);
    CHECK(locals[1] == shear);
    CHECK(locals[0] == affine({Vec3(0, 0, 7), Quat(0, 0, 0, 1), Vec3(2, 2, 2)}));
    clip.channels[0].node = 1;
    locals = sample_locals(skeleton, clip, 0);
    CHECK(locals[1] == affine({.scale = Vec3(2, 2, 2)}));
  }

  TEST_CASE("a vertex between two joints goes half the way of each") {
    Surface s;
    s.position = {{1, 0, 0}, {0, 1, 0}};
    s.influences = {{{0, 0.5}, {1, 0.5}}, {{1, 1}}};
    Palette palette(2, identity());
    palette[1].col(3) = Vec3(0, 0, 4);
    const std::vector<Vec3> posed = pose_vertices(s, palette);
    CHECK(posed[0] == Vec3(1, 0, 2));
    CHECK(posed[1] == Vec3(0, 1, 4));
  }

  TEST_CASE("morphs are added before the joints turn, points and normals alike") {
    Surface s;
    s.position = {{1, 0, 0}, {0, 1, 0}};
    s.influences = {{{0, 1}}, {{1, 1}}};
    s.morphs = {{{0, Vec3(0, 0, 2)}, {1, Vec3(1, 0, 0)}}, {{1, Vec3(0, 3, 0)}}};
    s.wedges = {{0, 0}, {1, 0}};
    s.layout.normal = true;
    s.attributes.resize(2, 3);
    s.attributes << 0, 0, 1, 0, 0, 1;
    s.normal_morphs = {{{1, Vec3(2, 0, 0)}}, {{1, Vec3(2, 0, 0)}}};
    Palette palette(2, identity());
    palette[1].leftCols<3>() << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // a quarter turn about z
    palette[1].col(3) = Vec3(0, 0, 4);
    const std::vector<double> weights = {0.5, -1};
    const std::vector<Vec3> posed = pose_vertices(s, palette, weights);
    CHECK(posed[0] == Vec3(0, 0, 1));
    CHECK(posed[1] == Vec3(2, 0, 4));
    const Rows turned = pose_attributes(s, palette, weights);
    const Vec3 n = Vec3(-2, 0, 1).normalized();
    CHECK((turned.row(0).transpose() - n).norm() < 1e-12);
    CHECK((turned.row(1).transpose() - Vec3(0, n.x(), n.z())).norm() < 1e-12);
    CHECK(pose_vertices(s, palette)[0] == Vec3(1, 0, 0));
    CHECK(pose_attributes(s, palette).row(0) == s.attributes.row(0));
  }

  TEST_CASE("weights of morphs are those of the clip for the node it moves and those at rest for others") {
    const std::vector<Morph> morphs = {{"a", 3, 0.25}, {"b", 7, 0}, {"c", 3, 0}, {"d", 7, 0.5}};
    Rows values(2, 2);
    values << 0, 1, 1, 3;
    const Clip clip{"talk", {{7, Path::MorphWeights, Interpolation::Linear, {0, 2}, values}}};
    CHECK(sample_morph_weights(morphs, clip, 1) == std::vector<double>{0.25, 0.5, 0, 2});
    CHECK(sample_morph_weights(morphs, {}, 1) == std::vector<double>{0.25, 0, 0, 0.5});
    CHECK(sample_morph_weights(std::span(morphs).subspan(1, 2), {}, 1).empty());  // all are 0
    CHECK(sample_morph_weights({}, clip, 1).empty());
  }

  TEST_CASE("the targets that move the most are poses of their own and frames carry the clip's weights") {
    Character c = bending_tube(12, 40, 5);
    const int node = c.parts[0].node;
    c.morphs = {{"slight", node}, {"still", node}, {"wide", node}, {"local", node}};
    for (const Vec3& x : c.surface.position) {
      MorphOffsets& offsets = c.surface.morphs.emplace_back();
      offsets.push_back({0, Vec3(0, 0, 0.01)});
      offsets.push_back({2, Vec3(0, 0, 0.1)});
      if (x.y() > 2) offsets.push_back({3, Vec3(0, 0, 0.1)});
    }
    c.clips[0].channels.push_back({node, Path::MorphWeights, Interpolation::Step, {0}, Rows::Ones(1, 4)});
    const PoseSet set = choose_poses(c, {});
    REQUIRE(set.morphs.size() == 3);
    CHECK(set.morphs[0].source == "morph slight");
    CHECK(set.morphs[1].source == "morph wide");
    CHECK(set.morphs[1].morph_weights == std::vector<double>{0, 0, 1, 0});
    CHECK(set.morphs[1].palette == set.examples[0].palette);
    CHECK(choose_poses(c, {.morphs = 2}).morphs[0].source == "morph wide");
    CHECK(choose_poses(c, {.morphs = 0}).morphs.empty());
    CHECK(set.examples[0].morph_weights.empty());
    int carrying = 0;
    for (const auto* frames : {&set.examples, &set.unseen_clip}) {
      for (const Pose& pose : *frames) {
        const bool bends = pose.source.starts_with("clip bend");
        CHECK(pose.morph_weights == (bends ? std::vector<double>(4, 1) : std::vector<double>()));
        carrying += bends;
      }
    }
    CHECK(carrying > 3);
  }

  TEST_CASE("a rigid motion of the whole palette moves the whole surface") {
    std::mt19937 random(1);
    const Character c = bending_tube(12, 40, 5);
    Palette palette = sample(c.skeleton, c.clips[0], 0.7);
    const std::vector<Vec3> before = pose_vertices(c.surface, palette);
    const Affine motion = affine({random_vector(random, 3), turn(random_vector(random, 2)), Vec3::Ones()});
    for (Affine& T : palette) T = compose(motion, T);
    const std::vector<Vec3> after = pose_vertices(c.surface, palette);
    for (size_t v = 0; v < before.size(); ++v)
      CHECK((after[v] - transform(motion, before[v])).norm() < 1e-13);
  }

  TEST_CASE("the examples are the bind pose and frames of the clips and range of motion") {
    const Character c = bending_tube(12, 40, 5);
    const PoseSet set = choose_poses(c, {});
    REQUIRE(set.examples.size() == 1 + 9 + 8);
    CHECK(set.unseen_clip.size() == 24);
    CHECK(set.unseen_motion.size() == 8);
    CHECK(set.examples[0].source == "bind");
    for (const Affine& T : set.examples[0].palette) CHECK(T == identity());
    // The farthest from the bind pose is a clip's end: all joints fully bent.
    CHECK(set.examples[1].source == "clip bend at 1.0000 s");
    CHECK(set.examples[2].source == "clip twist at 1.0000 s");
    for (int p = 1; p <= 9; ++p) CHECK(set.examples[size_t(p)].source.starts_with("clip "));
    CHECK(set.examples[10].source == "range of motion 1");

    std::vector<Pose> all = set.examples;
    all.insert(all.end(), set.unseen_clip.begin(), set.unseen_clip.end());
    all.insert(all.end(), set.unseen_motion.begin(), set.unseen_motion.end());
    CHECK(unlike(all, all, c.surface));
    const std::vector<std::string> names = sources(all);
    CHECK(std::set(names.begin(), names.end()).size() == all.size());
    for (const Pose& pose : set.unseen_clip) CHECK(pose.source.starts_with("clip "));
  }

  TEST_CASE("each chosen frame is farther from those before than any that comes after it") {
    Character c = bending_tube(8, 20, 4);
    c.clips.resize(1);  // bending by one angle about one axis: distance grows with the angle
    const PoseSet set = choose_poses(c, {.from_clips = 5, .range_of_motion = 0});
    // Farthest point on a line: the end, then about the middle, then about the quarters.
    REQUIRE(set.examples.size() == 6);
    CHECK(set.examples[1].source == "clip bend at 1.0000 s");
    std::vector<double> times;
    for (size_t p = 2; p < 6; ++p) times.push_back(std::stod(set.examples[p].source.substr(13)));
    CHECK(times[0] == doctest::Approx(0.5).epsilon(0.1));
    std::sort(times.begin(), times.begin() + 3);
    CHECK(times[0] == doctest::Approx(0.25).epsilon(0.2));
    CHECK(times[2] == doctest::Approx(0.75).epsilon(0.1));
  }

  TEST_CASE("a rigid motion of the whole character is no new pose") {
    Character c = bending_tube(8, 20, 4);
    // Only the root moves: it turns and walks away.
    MatX walk(2, 3), spin(2, 4);
    walk << 0, 0, 0, 100, 3, 0;
    spin << 0, 0, 0, 1, 0, 1, 0, 0;
    c.clips = {{"walk",
                {{0, Path::Translation, Interpolation::Linear, {0, 1}, walk},
                 {0, Path::Rotation, Interpolation::Linear, {0, 1}, spin}}}};
    const PoseSet set = choose_poses(c, {.range_of_motion = 0});
    CHECK(sources(set.examples) == std::vector<std::string>{"bind"});
    CHECK(set.unseen_clip.empty());

    // Bending while it does so is: the same frames are chosen as without the walk.
    Character bending = bending_tube(8, 20, 4);
    bending.clips.resize(1);
    Character both = bending;
    both.clips[0].channels.insert(both.clips[0].channels.end(), c.clips[0].channels.begin(),
                                  c.clips[0].channels.end());
    const PoseOptions options{.from_clips = 3, .range_of_motion = 0};
    CHECK(sources(choose_poses(both, options).examples) == sources(choose_poses(bending, options).examples));
  }

  TEST_CASE("fewer frames than asked for give fewer poses") {
    Character c = bending_tube(8, 20, 4);
    const PoseSet set = choose_poses(c, {.from_clips = 50, .range_of_motion = 0, .frames_per_second = 4});
    CHECK(set.examples.size() == 1 + 2 * 4);  // both clips' first frame is the bind pose
    CHECK(set.unseen_clip.empty());
    c.clips.clear();
    CHECK(choose_poses(c, {.range_of_motion = 0}).examples.size() == 1);
  }

  TEST_CASE("every key of a pose clip is an example and the frames chosen keep away from them") {
    Character c = bending_tube(8, 20, 4);
    const PoseSet set = choose_poses(c, {.from_clips = 1, .range_of_motion = 0, .pose_clips = {"twist"}});
    CHECK(sources(set.examples) == std::vector<std::string>{"bind", "clip twist at 0.0000 s",
                                                            "clip twist at 1.0000 s",
                                                            "clip bend at 1.0000 s"});
    CHECK_THROWS_AS(choose_poses(c, {.pose_clips = {"run"}}), Error);
    try {
      choose_poses(c, {.pose_clips = {"run"}});
    } catch (const Error& e) {
      CHECK(e.fault == Fault::Usage);
      CHECK(std::string(e.what()).find("bend, twist") != std::string::npos);
    }
    CHECK_THROWS_AS(choose_poses(c, {.frames_per_second = 0}), Error);
  }

  TEST_CASE("range of motion stays a tenth around what the clips show and leaves the root") {
    Character c = bending_tube(8, 20, 4);
    c.clips.resize(1);  // bend: 0 to 40 degrees about z for joints 1 to 3
    const double degree = pi / 180;
    const PoseSet set = choose_poses(c, {.from_clips = 0, .range_of_motion = 40});
    REQUIRE(set.examples.size() == 41);
    double least = 1e9, most = -1e9;
    for (size_t p = 1; p < set.examples.size(); ++p) {
      const std::vector<Vec3> turned = turns(set.examples[p]);
      CHECK(turned[0].norm() < 1e-12);
      for (size_t b = 1; b < turned.size(); ++b) {
        CHECK(turned[b].head<2>().norm() < 1e-12);
        least = std::min(least, turned[b].z()), most = std::max(most, turned[b].z());
      }
    }
    CHECK(least > -4.001 * degree);
    CHECK(least < -2 * degree);
    CHECK(most < 44.001 * degree);
    CHECK(most > 42 * degree);
  }

  TEST_CASE("a joint that the clips leave alone stays still in the range of motion") {
    Character c = bending_tube(8, 20, 4);
    c.clips.resize(1);
    c.clips[0].channels.resize(1);  // joint 1 alone
    const PoseSet set = choose_poses(c, {.from_clips = 0, .range_of_motion = 4});
    REQUIRE(set.examples.size() == 5);
    for (size_t p = 1; p < 5; ++p) {
      const std::vector<Vec3> turned = turns(set.examples[p]);
      CHECK(turned[1].norm() > 0);
      CHECK(turned[2].norm() < 1e-12);
      CHECK(turned[3].norm() < 1e-12);
    }
  }

  TEST_CASE("without clips every joint but the root goes up to 35 degrees") {
    Character c = bending_tube(8, 20, 4);
    c.clips.clear();
    c.skeleton.nodes.push_back({.name = "unused", .parent = 1});
    c.skeleton.joints.push_back({5, c.skeleton.joints[1].inverse_bind});
    const PoseSet set = choose_poses(c, {.range_of_motion = 40});
    REQUIRE(set.examples.size() == 41);
    const double limit = 35 * pi / 180;
    Vec3 least = Vec3::Constant(9), most = Vec3::Constant(-9);
    for (size_t p = 1; p < set.examples.size(); ++p) {
      const std::vector<Vec3> turned = turns(set.examples[p]);
      CHECK(turned[0].norm() < 1e-12);
      for (size_t b = 1; b < 4; ++b) least = least.cwiseMin(turned[b]), most = most.cwiseMax(turned[b]);
      CHECK((set.examples[p].palette[4] - set.examples[p].palette[1]).norm() < 1e-12);  // unused: still
    }
    CHECK(least.minCoeff() >= -limit - 1e-12);
    CHECK(most.maxCoeff() <= limit + 1e-12);
    CHECK(least.maxCoeff() < -0.9 * limit);
    CHECK(most.minCoeff() > 0.9 * limit);
  }

  TEST_CASE("poses depend on the seed and on nothing else") {
    const Character c = bending_tube(12, 40, 5);
    PoseSet one_thread;
    {
      const ThreadLimit control(1);
      one_thread = choose_poses(c, {});
    }
    const PoseSet threads = choose_poses(c, {}), other = choose_poses(c, {.seed = 2});
    check_same(one_thread.examples, threads.examples);
    check_same(one_thread.unseen_clip, threads.unseen_clip);
    check_same(one_thread.unseen_motion, threads.unseen_motion);
    check_same(threads.unseen_clip, other.unseen_clip);
    CHECK(threads.examples.back().palette != other.examples.back().palette);
    CHECK(threads.unseen_motion.back().palette != other.unseen_motion.back().palette);
  }

  TEST_CASE("very long and very many clips are thinned and not waited for") {
    Character c = bending_tube(8, 20, 4);
    for (Channel& channel : c.clips[0].channels) channel.times = {0, 1e12};
    for (int i = 0; i < 5000; ++i) c.clips.push_back({"empty", {}});
    const PoseSet set = choose_poses(c, {.from_clips = 2, .range_of_motion = 0});
    CHECK(set.examples.size() == 3);
    CHECK(set.unseen_clip.size() == 24);
  }
}
