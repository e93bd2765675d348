// SPDX-License-Identifier: MIT
#include "pipeline/refine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pipeline/fit_attributes.h"
#include "pipeline/fit_morphs.h"
#include "pipeline/large_pages.h"
#include "pipeline/metrics/skinned_point.h"
#include "pipeline/morphs.h"
#include "pipeline/parallel.h"
#include "pipeline/seam_pairs.h"

namespace skinlod {
namespace {

// What follows was measured on five characters at 50, 25, 10 and 5 %, as the RMS error over unseen clips.
// After three sweeps of one set of pairs five more gain 0.3 %; a second set of pairs gains 3 %.
constexpr int kSweeps = 3;

// On so large a level two are as good: its faces are near the surface from the start. At 50 and 25 % of two
// characters cut to 225 and 167 thousand triangles the third changed the RMS by -1.1 to +1.4 %.
constexpr int kManyFaces = 40000, kSweepsOfMany = 2;

// How much a place also holds on to where it is, against the plane it is drawn to: without it what lies in
// the plane slides, with ten times as much it is 1 % worse.
constexpr double kHold = 0.01;

// A face may turn by as much as has this cosine from how the collapse left it, in any pose.
constexpr double kMostTurned = 0.1;

// How strongly seams hold against the faces. Points slide along the surface and take seams with them, and
// then a strip has the texture of the other side. On the six characters that deform this takes 23 % of the uv
// error, for 1.7 % of the positions'; half of it 19 % for 1.0 %. Borders held in the same way make both
// worse.
constexpr double kSeam = 0.03;

// More places than these on the original, to a face of the level, and the poses take turns with them: every
// pose has so many, and every place some poses. All of them in all poses make no difference.
constexpr size_t kGivenPerFace = 8;

// More joints than this are not tried for one vertex: its own and its neighbours' are rarely more.
constexpr int kMostCandidates = 12;

// Places on a face of the level are tied to planes: sum of weight x (off + sum_k share_k normal . d_k)^2,
// where the corners have gone by d_k. Over any number of ties that is one quadratic form of the d_k. There is
// one for each face in each pose, which is most of what fitting takes of memory: hence floats.
class Ties {
 public:
  static Ties none() {
    Ties ties;
    ties.A_ = {}, ties.b_.fill(Eigen::Vector3f::Zero()), ties.c_ = 0;
    return ties;
  }

  void add(const Vec3& share, const Vec3& normal, double off, double weight) {
    const std::array<double, 6> square = {normal[0] * normal[0], normal[1] * normal[0],
                                          normal[1] * normal[1], normal[2] * normal[0],
                                          normal[2] * normal[1], normal[2] * normal[2]};
    std::array<float, 6> pull;
    for (size_t i = 0; i < 6; ++i) pull[i] = float(weight * square[i]);
    for (int k = 0; k < 3; ++k) {
      for (int l = 0; l <= k; ++l) {
        const auto both = float(share[k] * share[l]);
        for (size_t i = 0; i < 6; ++i) A_[k * (k + 1) / 2 + l][i] += both * pull[i];
      }
      b_[k] += (weight * off * share[k] * normal).cast<float>();
    }
    c_ += float(weight * off * off);
  }

  Mat3 curvature(int corner) const { return block(corner, corner); }
  Vec3 slope(int corner) const { return b_[corner].cast<double>(); }
  double now() const { return c_; }

  // From here on d is measured from where `corner` is after this step.
  void move(int corner, const Vec3& step) {
    c_ += float(step.dot(2 * slope(corner) + curvature(corner) * step));
    for (int l = 0; l < 3; ++l) b_[l] += (block(corner, l) * step).cast<float>();
  }

 private:
  Mat3 block(int k, int l) const {
    const auto& [xx, xy, yy, xz, yz, zz] = A_[std::max(k, l) * (std::max(k, l) + 1) / 2 + std::min(k, l)];
    Mat3 A;
    A << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    return A;
  }

  std::array<std::array<float, 6>, 6> A_;  // of the corners (0,0), (1,0), (1,1), (2,0), (2,1), (2,2)
  std::array<Eigen::Vector3f, 3> b_;
  float c_;
};

// What each of many items has in every pose: beside each other for one item, since a vertex moves in all
// poses at once.
template <class T>
class InPoses {
 public:
  InPoses() = default;
  InPoses(size_t items, size_t poses) : poses_(poses), all_(items * poses) {}  // not set yet
  InPoses(size_t items, size_t poses, const T& each) : InPoses(items, poses) {
    parallel_for(int(items), [&](int i) { std::ranges::fill((*this)[i], each); });
  }
  std::span<T> operator[](int i) { return {all_.data() + size_t(i) * poses_, poses_}; }
  std::span<const T> operator[](int i) const { return {all_.data() + size_t(i) * poses_, poses_}; }

 private:
  size_t poses_ = 0;
  LargeVector<T> all_;
};

// For one vertex while all others stand still the ties around it are a quadric in each pose, and the
// collapse's two steps solve it. Vertices without a face in common are moved side by side, colour after
// colour.
class LevelFit {
 public:
  LevelFit(const Original& original, Surface& level, std::span<const Pose> poses,
           const std::vector<char>& locked, const RefineOptions& options)
      : original_(original),
        level_(level),
        locked_(locked),
        options_(options),
        of_level_(level),
        posed_(level.position.size(), poses.size()),
        upright_(size_t(level.face_count()), poses.size()),
        tiny_(1e-6 * diagonal(original.surface.position)) {
    for (const Pose& pose : poses) palettes_.push_back(pose.palette);
    const Skin skin(level);
    parallel_for(int(poses.size()), [&](int p) {
      const std::vector<Vec3> here = skin.posed(palettes_[p]);
      for (int v = 0; v < int(here.size()); ++v) posed_[v][p] = here[v];
      for (int f = 0; f < of_level_.face_count(); ++f)
        upright_[f][p] = of_level_.vector_area(here, f).normalized().cast<float>();
    });
    colour();
  }

  void round(bool last) {
    ties_ = {};  // what pairing takes may take their room
    pairs_ = paired(original_, level_);
    const auto on_original = size_t(std::ranges::count(pairs_, false, &Pair::given_on_level));
    turns_ = std::max<size_t>(1, on_original / (kGivenPerFace * size_t(of_level_.face_count())));
    std::vector<SeamPair> seams;
    if (options_.attributes) seams = paired_seams(original_, level_, pairs_);
    ties_ = InPoses<Ties>(size_t(of_level_.face_count()), palettes_.size(), Ties::none());
    parallel_for(int(palettes_.size()), [&](int p) { tie(p, seams); });
    const int sweeps = of_level_.face_count() > kManyFaces ? kSweepsOfMany : kSweeps;
    for (int sweep = 1; sweep <= sweeps; ++sweep) {
      const bool in_bytes = options_.byte_weights && last && sweep == sweeps;
      for (const auto& vertices : colours_)
        parallel_for(int(vertices.size()), [&](int i) { move(vertices[i], in_bytes); });
    }
  }

  Pairs take_pairs() { return std::move(pairs_); }

 private:
  void colour() {
    std::vector<int> of(level_.position.size(), -1);
    for (int v = 0; v < int(of.size()); ++v) {
      if (locked_[v]) continue;
      std::vector<char> taken(colours_.size() + 1, 0);
      for (const int f : of_level_.faces_around(v)) {
        for (const int u : of_level_.vertices(f)) {
          if (of[u] >= 0) taken[of[u]] = 1;
        }
      }
      of[v] = int(std::find(taken.begin(), taken.end(), 0) - taken.begin());
      if (of[v] == int(colours_.size())) colours_.emplace_back();
      colours_[of[v]].push_back(v);
    }
  }

  // The plane is square to the way between the two places, which is how the distance between them changes;
  // where they touch, the face of the place that was found. On a seam it is the one through the seam that is
  // square to the face: along it places may slide.
  void tie(int p, const std::vector<SeamPair>& seams) {
    const std::vector<Vec3> there = original_.skin.posed(palettes_[p]);
    std::vector<Vec3> here;
    for (int v = 0; v < of_level_.vertex_count(); ++v) here.push_back(posed_[v][p]);
    size_t turn = size_t(p);
    for (const Pair& at_rest : pairs_) {
      if (!at_rest.given_on_level && turn++ % turns_ != 0) continue;
      const double weight = at_rest.area * (at_rest.given_on_level ? 1 : double(turns_));
      const Pair pair = found_again(at_rest, original_.faces, there, of_level_, here);
      const Vec3 a = original_.faces.vector_area(there, pair.original.face);
      const Vec3 b = of_level_.vector_area(here, pair.level.face);
      if (!look_alike(a, b)) continue;
      const Vec3 way = of_level_.at(here, pair.level) - original_.faces.at(there, pair.original);
      const double length = way.norm();
      const Vec3 n = length > tiny_ ? Vec3(way / length) : (pair.given_on_level ? a : b).normalized();
      ties_[pair.level.face][p].add(pair.level.share, n, n.dot(way), weight);
    }
    for (const SeamPair& seam : seams) {
      const Vec3 along = there[seam.edge.removed] - there[seam.edge.kept];
      const Vec3 n = along.cross(original_.faces.vector_area(there, seam.original.face)).normalized();
      const Vec3 way = of_level_.at(here, seam.level) - original_.faces.at(there, seam.original);
      ties_[seam.level.face][p].add(seam.level.share, n, n.dot(way), kSeam * seam.area);
    }
  }

  int corner(int face, int v) const {
    const auto& vertices = of_level_.vertices(face);
    return int(std::find(vertices.begin(), vertices.end(), v) - vertices.begin());
  }

  // What the ties around `v` say in each pose, as a function of where it goes.
  std::vector<Quadric> errors_around(int v) const {
    std::vector<Quadric> around(palettes_.size(), {Mat3::Zero(), Vec3::Zero(), 0});
    for (const int f : of_level_.faces_around(v)) {
      const int k = corner(f, v);
      const auto ties = ties_[f];
      for (size_t p = 0; p < around.size(); ++p)
        around[p].A += ties[p].curvature(k), around[p].b += ties[p].slope(k), around[p].c += ties[p].now();
    }
    for (size_t p = 0; p < around.size(); ++p) {
      auto& [A, b, c] = around[p];
      A.diagonal().array() += kHold / 3 * A.trace();
      const Vec3& x = posed_[v][p];
      c += x.dot(A * x) - 2 * b.dot(x);
      b -= A * x;
    }
    return around;
  }

  // The joints that the vertex may come to follow: its own and its neighbours'.
  std::vector<int> candidates(int v) const {
    Influences all = level_.influences[v];
    for (const int f : of_level_.faces_around(v)) {
      for (const int u : of_level_.vertices(f)) {
        for (const Influence& i : level_.influences[u]) {
          const auto its = std::ranges::find(all, i.joint, &Influence::joint);
          if (its == all.end()) {
            all.push_back(i);
          } else {
            its->weight += i.weight;
          }
        }
      }
    }
    Influences few = largest(std::move(all), kMostCandidates);
    std::vector<int> joints;
    for (const Influence& i : level_.influences[v]) joints.push_back(i.joint);
    for (const Influence& i : few) {
      if (joints.size() < size_t(kMaxJoints)) joints.push_back(i.joint);
    }
    std::sort(joints.begin(), joints.end());
    joints.erase(std::unique(joints.begin(), joints.end()), joints.end());
    return joints;
  }

  bool turns_a_face(int v, const std::vector<Vec3>& to) const {
    for (const int f : of_level_.faces_around(v)) {
      const auto& vertices = of_level_.vertices(f);
      const int k = corner(f, v);
      const auto a = posed_[vertices[(k + 1) % 3]], b = posed_[vertices[(k + 2) % 3]];
      const auto upright = upright_[f];
      for (size_t p = 0; p < palettes_.size(); ++p) {
        if (upright[p].isZero(0)) continue;
        const Vec3 after = (a[p] - to[p]).cross(b[p] - to[p]);
        if (!(after.dot(upright[p].cast<double>()) > kMostTurned * after.norm())) return true;
      }
    }
    return false;
  }

  void move(int v, bool in_bytes) {
    const SkinnedQuadric E(errors_around(v), palettes_, candidates(v), level_.position[v]);
    const SkinnedPoint start{level_.position[v], level_.influences[v]};
    SkinnedPoint best = solved(E, start, options_.max_influences, options_.weights);
    if (!(error_at(E, best) < error_at(E, start))) best = start;
    if (in_bytes) best = rounded(E, best);
    std::vector<Vec3> to;
    for (const Palette& palette : palettes_)
      to.push_back(transform(blend(best.influences, palette), best.position));
    if (turns_a_face(v, to)) return;
    level_.position[v] = best.position, level_.influences[v] = best.influences;
    const auto from = posed_[v];
    for (const int f : of_level_.faces_around(v)) {
      const int k = corner(f, v);
      for (size_t p = 0; p < to.size(); ++p) ties_[f][p].move(k, to[p] - from[p]);
    }
    std::ranges::copy(to, from.begin());
  }

  const Original& original_;
  Surface& level_;
  const std::vector<char>& locked_;  // per vertex of the level
  const RefineOptions& options_;
  Neighbourhood of_level_;
  std::vector<Palette> palettes_;          // per pose
  InPoses<Vec3> posed_;                    // per vertex of the level
  InPoses<Eigen::Vector3f> upright_;       // per face of it: normals as the collapse left them
  Pairs pairs_;                            // at rest, as the last round found them
  size_t turns_ = 1;                       // poses that share the places on the original
  InPoses<Ties> ties_;                     // per face of the level
  std::vector<std::vector<int>> colours_;  // vertices without a face in common, none locked
  double tiny_;                            // metres: places this near touch
};

}  // namespace

Surface refined(const Original& original, Surface level, std::span<const Pose> poses,
                const RefineOptions& options) {
  if (options.rounds == 0) return level;
  const Surface before = level;
  const std::vector<char> locked = locked_vertices(level, options.borders);
  Pairs pairs;
  {  // what else it holds is gone before the attributes are fitted
    LevelFit fit(original, level, poses, locked, options);
    for (int r = 0; r < options.rounds; ++r) fit.round(r + 1 == options.rounds);
    pairs = fit.take_pairs();
  }
  const bool has_attributes = options.attributes && level.layout != AttributeLayout{};
  if (!has_attributes && morph_count(original.surface) == 0) return level;
  pairs = paired_in_charts(original, level, std::move(pairs));
  if (has_attributes) fit_attributes(original.surface, before, pairs, locked, level);
  fit_morphs(original.surface, before, pairs, locked, level);
  return level;
}

}  // namespace skinlod
