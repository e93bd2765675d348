// SPDX-License-Identifier: MIT
#include "pipeline/collapse.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <stdexcept>
#include <vector>

#include "pipeline/error.h"
#include "pipeline/metrics/articulated.h"
#include "pipeline/metrics/rest_pose.h"
#include "pipeline/repair.h"
#include "tests/topology.h"

// Any index buffer through repair, weld and the collapse loop. Shared by libFuzzer and by the test of random
// index buffers.
namespace skinlod::fuzz {

inline void require(bool is_so, const char* fact) {
  if (!is_so) throw std::logic_error(fact);  // ends a fuzzer, and fails a test
}

inline constexpr int kVertices = 64;

// Two layers of 8 x 4 points at the same places. The second follows other joints for the half of it, so that
// some places weld and some stay doubled; every vertex has a wedge on either side of a seam.
inline Character character_of(std::span<const std::uint8_t> corners, size_t per_face) {
  Character c;
  c.name = "fuzz";
  c.skeleton.nodes = {{.name = "root"}, {.name = "tip", .parent = 0}};
  c.skeleton.joints = {{0}, {1}};
  c.parts = {{.name = "part"}};
  Surface& s = c.surface;
  s.layout = {.normal = true, .uv_sets = 1};
  s.attributes = Rows::Zero(2 * kVertices, s.layout.columns());
  for (int v = 0; v < kVertices; ++v) {
    const int place = v % 32;
    s.position.emplace_back(place % 8, place / 8, 0.3 * (place * place % 5));
    const double weight = v < 48 ? 0.125 * (place % 8) : 0.5;
    s.influences.push_back({{0, 1 - weight}, {1, weight}});
    for (int side = 0; side < 2; ++side) {
      s.attributes(2 * v + side, s.layout.normal_at() + 2) = 1;
      s.attributes(2 * v + side, s.layout.uv_at(0)) = side;
      s.wedges.push_back({v, 0});
    }
  }
  for (size_t i = 0; i + per_face <= corners.size(); i += per_face) {
    std::vector<int> face;
    // bytes name the 128 wedges twice over, but for the last, which names one that is not there
    for (size_t k = 0; k < per_face; ++k) face.push_back(corners[i + k] == 255 ? 128 : corners[i + k] % 128);
    s.add_face(face);
  }
  return c;
}

inline void check(const Mesh& mesh) {
  int triangles = 0;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    const auto face = mesh.face(f);
    if (face.empty()) continue;
    require(face.size() == 3 || face.size() == 4, "a face has three or four corners");
    triangles += int(face.size()) - 2;
    require(std::set<int>(face.begin(), face.end()).size() == face.size(), "its corners differ");
    for (const int v : face) {
      const auto around = mesh.faces_around(v);
      require(std::count(around.begin(), around.end(), f) == 1, "each corner knows the face");
    }
  }
  require(triangles == mesh.triangle_count(), "the triangles are counted");
  std::set<std::pair<int, int>> sides, edges;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i)
      sides.insert(std::minmax(face[i], face[(i + 1) % face.size()]));
  }
  for (int e = 0; e < mesh.edge_slots(); ++e) {
    const auto [kept, removed] = mesh.edge(e);
    if (kept >= 0)
      require(edges.insert(std::minmax(kept, removed)).second, "no two edges have the same ends");
  }
  require(edges == sides, "the edges are the sides of the faces");
  require(int(edges.size()) == mesh.edge_count(), "the edges are counted");
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    require(mesh.position[v].allFinite(), "positions are finite");
    for (const int f : mesh.faces_around(v)) {
      const auto face = mesh.face(f);
      require(std::count(face.begin(), face.end(), v) == 1, "each face around a vertex has it");
    }
  }
}

// How many faces lie on another one, whichever way they are turned.
inline int twins(const Mesh& mesh) {
  int count = 0;
  std::set<std::set<int>> seen;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    const auto face = mesh.face(f);
    if (!face.empty()) count += !seen.insert({face.begin(), face.end()}).second;
  }
  return count;
}

inline int alive(const Mesh& mesh) {
  int count = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) count += mesh.alive(v);
  return count;
}

template <class Metric>
size_t collapse_and_check(Metric metric, Mesh mesh, int target) {
  check(mesh);
  const int alive_before = alive(mesh), twins_before = twins(mesh);
  const History history = collapse(mesh, metric, target);
  check(mesh);
  const Surface left = mesh.surface(metric.influences());
  require(alive(mesh) + int(history.size()) == alive_before, "a collapse takes one vertex and no more");
  require(twins(mesh) <= twins_before, "no face comes to lie on another");
  for (const Influences& influences : left.influences) {
    double sum = 0;
    for (const Influence& i : influences) {
      require(i.weight > 0, "weights are positive");
      sum += i.weight;
    }
    require(std::abs(sum - 1) < 1e-9, "weights sum to 1");
  }
  return history.size();
}

// The first byte chooses; the others are corners. Returns the number of collapses.
inline size_t collapse_faces_of(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return 0;
  const std::uint8_t choice = bytes[0];
  Character c = character_of(bytes.subspan(1), choice & 1 ? 4 : 3);
  try {
    repair(c);
    weld(c);
  } catch (const Error& e) {
    require(e.fault == Fault::Input, e.what());
    return 0;
  }
  const Surface& s = c.surface;
  const Mesh mesh(s);
  const int target = mesh.triangle_count() * (choice >> 2 & 3) / 4;
  if (choice & 2) return collapse_and_check(RestPoseMetric(mesh, s.influences), mesh, target);
  const std::vector<Pose> poses = {{"bind", Palette(2, identity())}, {"bent", random_palette(2, choice, 1)}};
  return collapse_and_check(ArticulatedMetric(mesh, s.influences, poses), mesh, target);
}

}  // namespace skinlod::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  skinlod::fuzz::collapse_faces_of({data, std::min<std::size_t>(size, 4096)});
  return 0;
}
