// SPDX-License-Identifier: MIT
#include "pipeline/repair.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "pipeline/error.h"
#include "pipeline/findings.h"

namespace skinlod {
namespace {

// Beyond this the products of lengths that the metrics need would leave the range of numbers.
constexpr double kFarthest = 1e12;  // metres

// Sums within this of 1 are rounding: weights of 16 bits and up, a few of them.
constexpr double kSumTolerance = 1e-4;

// False for NaN, too.
bool in_bounds(const auto& values) { return (values.array().abs() < kFarthest).all(); }

// Points by halves along x, y and z in turn: finds the nearest in logarithmic time.
class PointTree {
 public:
  PointTree(std::span<const Vec3> position, std::vector<int> points)
      : position_(position), points_(std::move(points)) {
    split(0, points_.size(), 0);
  }

  /// The point nearest to `x`.
  int nearest(const Vec3& x) const {
    Nearest found;
    search(0, points_.size(), 0, x, found);
    return found.point;
  }

 private:
  struct Nearest {
    double square = std::numeric_limits<double>::infinity();
    int point = -1;
  };

  void split(size_t begin, size_t end, int axis) {
    if (end - begin < 2) return;
    const size_t middle = (begin + end) / 2;
    const auto at = [&](size_t i) { return points_.begin() + std::ptrdiff_t(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](int a, int b) {
      return std::pair(position_[a][axis], a) < std::pair(position_[b][axis], b);
    });
    split(begin, middle, (axis + 1) % 3);
    split(middle + 1, end, (axis + 1) % 3);
  }

  void search(size_t begin, size_t end, int axis, const Vec3& x, Nearest& found) const {
    if (begin == end) return;
    const size_t middle = (begin + end) / 2;
    const Vec3& here = position_[points_[middle]];
    if (const double square = (here - x).squaredNorm(); square < found.square) {
      found = {square, points_[middle]};
    }
    const double off = x[axis] - here[axis];
    const int next = (axis + 1) % 3;
    const std::pair low(begin, middle), high(middle + 1, end);
    const auto &its = off < 0 ? low : high, &other = off < 0 ? high : low;
    search(its.first, its.second, next, x, found);
    if (off * off < found.square) search(other.first, other.second, next, x, found);
  }

  std::span<const Vec3> position_;
  std::vector<int> points_;
};

void check_skeleton(const Character& character) {
  const Skeleton& skeleton = character.skeleton;
  parents_first(skeleton);  // throws where it is broken
  const auto sound = [](const Transform& t) {
    return in_bounds(t.translation) && in_bounds(t.rotation) && in_bounds(t.scale);
  };
  for (const Node& node : skeleton.nodes) {
    if (sound(node.rest) && (!node.matrix || in_bounds(*node.matrix))) continue;
    throw Error{Fault::Input, character.name + ": node '" + node.name +
                                  "': its transform is not finite: export the skeleton again"};
  }
  for (const Joint& joint : skeleton.joints) {
    const bool there = joint.node >= 0 && joint.node < int(skeleton.nodes.size());
    if (there && in_bounds(joint.inverse_bind)) continue;
    throw Error{Fault::Input,
                character.name + ": joint '" + (there ? skeleton.nodes[joint.node].name : "?") +
                    "': its bind matrix is not finite or its node not there: export the skin again"};
  }
  if (skeleton.joints.empty()) {
    throw Error{Fault::Input, character.name + ": has no joints: export it with its skeleton and skin"};
  }
}

// The surface as it is mended, with what all steps need to know of it.
class SurfaceRepair {
 public:
  explicit SurfaceRepair(Character& character)
      : character_(character), surface_(character.surface), findings_(character.parts) {
    const size_t vertices = surface_.position.size();
    part_.assign(vertices, -1);
    used_.assign(vertices, false);
    for (const Wedge& wedge : surface_.wedges) {
      if (in_range(wedge) && part_[wedge.vertex] < 0) part_[wedge.vertex] = wedge.part;
    }
    for (const int w : surface_.corners) {
      if (in_range(w)) used_[surface_.wedges[w].vertex] = true;
    }
  }

  void repair_positions() {
    for (int v = 0; v < int(surface_.position.size()); ++v) {
      if (in_bounds(surface_.position[v])) continue;
      note(WarningCode::PositionNotFinite, v, "faces removed");
      lost_.push_back(v);  // in ascending order
      surface_.position[v].setZero();
    }
    repair_offsets(surface_.morphs, [](int v) { return v; });
    repair_offsets(surface_.normal_morphs, [&](int w) { return vertex(w); });
  }

  void repair_attributes() {
    const AttributeLayout& layout = surface_.layout;
    for (int w = 0; w < int(surface_.wedges.size()); ++w) {
      if (layout.normal) repair_direction(w, layout.normal_at());
      if (layout.tangent) {
        repair_direction(w, layout.tangent_at());
        repair_values(w, layout.tangent_at() + 3, 1);
        double& handedness = surface_.attributes(w, layout.tangent_at() + 3);
        handedness = handedness < 0 ? -1 : 1;
      }
      for (int set = 0; set < layout.uv_sets; ++set) repair_values(w, layout.uv_at(set), 2);
      for (int set = 0; set < layout.colour_sets; ++set) repair_values(w, layout.colour_at(set), 4);
    }
  }

  void repair_influences() {
    surface_.influences.resize(surface_.position.size());
    for (int v = 0; v < int(surface_.influences.size()); ++v) repair_influences_of(v);
    tie_vertices_without_influence();
  }

  void repair_faces() {
    Surface mended;
    for (int f = 0; f < surface_.face_count(); ++f) {
      const auto face = surface_.face(f);
      const auto stray = std::find_if(face.begin(), face.end(), [&](int w) { return !in_range(w); });
      if (stray != face.end()) {
        const bool known = stray != face.begin();
        findings_.note(WarningCode::FaceOutOfRange, known ? surface_.wedges[face[0]].part : -1, "removed");
      } else if (std::any_of(face.begin(), face.end(), [&](int w) { return is_lost(vertex(w)); })) {
        continue;  // counted by its vertices
      } else if (!has_area(face)) {
        findings_.note(WarningCode::FaceDegenerate, face.empty() ? -1 : surface_.part(f),
                       "without area, removed");
      } else {
        mended.add_face(face);
      }
    }
    surface_.corners = std::move(mended.corners);
    surface_.face_begin = std::move(mended.face_begin);
    if (surface_.face_count() == 0) {
      throw Error{Fault::Input, character_.name +
                                    ": no face is left after repair: export it with a mesh of "
                                    "triangles or polygons that have an area"};
    }
  }

  Warnings warnings() const { return findings_.warnings(); }

 private:
  bool in_range(const Wedge& wedge) const {
    return wedge.vertex >= 0 && wedge.vertex < int(surface_.position.size()) && wedge.part >= 0 &&
           wedge.part < int(character_.parts.size());
  }
  bool in_range(int w) const {
    return w >= 0 && w < int(surface_.wedges.size()) && in_range(surface_.wedges[w]);
  }
  int vertex(int w) const { return surface_.wedges[w].vertex; }
  bool is_lost(int v) const { return std::binary_search(lost_.begin(), lost_.end(), v); }

  // Only vertices that a face names are told of.
  void note(WarningCode code, int v, std::string_view detail) {
    if (v >= 0 && v < int(used_.size()) && used_[v]) findings_.note(code, part_[v], detail);
  }

  void repair_offsets(std::vector<MorphOffsets>& offsets, const auto& vertex_of) {
    for (int i = 0; i < int(offsets.size()); ++i) {
      std::erase_if(offsets[i], [&](const MorphOffset& offset) {
        const bool there = offset.morph >= 0 && offset.morph < int(character_.morphs.size());
        const bool kept = there && in_bounds(offset.delta);
        if (!kept) note(WarningCode::AttributeNotFinite, vertex_of(i), "morph offset removed");
        return !kept || offset.delta.isZero(0);
      });
      std::stable_sort(offsets[i].begin(), offsets[i].end(),
                       [](const MorphOffset& a, const MorphOffset& b) { return a.morph < b.morph; });
    }
  }

  void repair_values(int w, int column, int columns) {
    auto values = surface_.attributes.row(w).segment(column, columns);
    if (in_bounds(values)) return;
    values = default_attributes(surface_.layout).segment(column, columns);
    note(WarningCode::AttributeNotFinite, vertex(w), "set to the default");
  }

  void repair_direction(int w, int column) {
    auto direction = surface_.attributes.row(w).segment<3>(column);
    const double length = direction.norm();
    direction /= length;  // no length: not finite
    repair_values(w, column, 3);
  }

  void repair_influences_of(int v) {
    Influences& influences = surface_.influences[v];
    const auto drop = [&](WarningCode code, std::string_view detail, const auto& is_wrong) {
      if (erase_if(influences, is_wrong) > 0) note(code, v, detail);
    };
    const int joints = int(character_.skeleton.joints.size());
    drop(WarningCode::InfluencesOutOfRange, "removed",
         [&](const Influence& i) { return i.weight != 0 && (i.joint < 0 || i.joint >= joints); });
    drop(WarningCode::WeightsNotFinite, "set to 0",
         [](const Influence& i) { return !std::isfinite(i.weight); });
    drop(WarningCode::WeightsNegative, "set to 0", [](const Influence& i) { return i.weight < 0; });
    erase_if(influences, [](const Influence& i) { return i.weight == 0; });
    std::stable_sort(influences.begin(), influences.end(),
                     [](const Influence& a, const Influence& b) { return a.joint < b.joint; });
    Influences merged;
    double sum = 0;
    for (const Influence& i : influences) {
      sum += i.weight;
      if (!merged.empty() && merged.back().joint == i.joint) {
        merged.back().weight += i.weight;
      } else {
        merged.push_back(i);
      }
    }
    if (!std::isfinite(sum)) {  // each is finite, but not all together
      note(WarningCode::WeightsNotFinite, v, "set to 0");
      merged.clear();
    } else if (!merged.empty()) {
      if (std::abs(sum - 1) > kSumTolerance) note(WarningCode::WeightsNotNormalised, v, "scaled to sum 1");
      for (Influence& i : merged) i.weight /= sum;
      erase_if(merged, [](const Influence& i) { return !(i.weight > 0); });  // lost in the division
    }
    influences = std::move(merged);
  }

  void tie_vertices_without_influence() {
    // Part -1 gathers the vertices that no wedge names; they hang on joint 0 until `weld` drops them.
    std::vector<std::vector<int>> bare(character_.parts.size()), tied(character_.parts.size());
    for (int v = 0; v < int(surface_.position.size()); ++v) {
      const bool is_bare = surface_.influences[v].empty();
      if (part_[v] >= 0 && !is_lost(v)) {
        (is_bare ? bare : tied)[part_[v]].push_back(v);
      } else if (is_bare) {
        surface_.influences[v] = {{0, 1}};
      }
    }
    for (int part = 0; part < int(bare.size()); ++part) {
      if (bare[part].empty()) continue;
      if (tied[part].empty()) {
        const int joint = joint_at(character_.parts[part].node);
        for (const int v : bare[part]) {
          surface_.influences[v] = {{joint, 1}};
          note(WarningCode::WeightsAbsent, v, "tied to the part's node");
        }
      } else {
        const PointTree tree(surface_.position, std::move(tied[part]));
        for (const int v : bare[part]) {
          surface_.influences[v] = surface_.influences[tree.nearest(surface_.position[v])];
          note(WarningCode::WeightsAbsent, v, "tied to what the nearest vertex of the part follows");
        }
      }
    }
  }

  // The joint that carries what hangs on `node`, which may get one now; joint 0 for no node.
  int joint_at(int node) {
    Skeleton& skeleton = character_.skeleton;
    if (node < 0 || node >= int(skeleton.nodes.size())) return 0;
    for (size_t b = 0; b < skeleton.joints.size(); ++b) {
      if (skeleton.joints[b].node == node) return int(b);
    }
    return add_skin(skeleton, std::vector<Joint>{{node, identity()}}).joint[0];
  }

  // False where every triangle of the face's fan is flat.
  bool has_area(std::span<const int> face) const {
    if (face.size() < 3) return false;
    const auto x = [&](size_t i) -> const Vec3& { return surface_.position[vertex(face[i])]; };
    double area = 0, size = 0;
    for (size_t i = 1; i < face.size(); ++i) {
      size = std::max(size, (x(i) - x(0)).squaredNorm());
      if (i + 1 < face.size()) area = std::max(area, (x(i) - x(0)).cross(x(i + 1) - x(0)).norm());
    }
    return area > 1e-12 * size;
  }

  Character& character_;
  Surface& surface_;
  Findings findings_;
  std::vector<int> part_;   // per vertex: that of its first wedge, or -1
  std::vector<bool> used_;  // per vertex: some face names it
  std::vector<int> lost_;   // vertices whose position was not finite
};

bool is_sound(const Channel& channel) {
  const auto finite = [](double x) { return std::isfinite(x); };
  const auto& times = channel.times;
  const Eigen::Index rows =
      Eigen::Index(times.size()) * (channel.interpolation == Interpolation::CubicSpline ? 3 : 1);
  const bool fits =
      channel.path == Path::MorphWeights || channel.values.cols() == (channel.path == Path::Rotation ? 4 : 3);
  return !times.empty() && fits && channel.values.rows() == rows && in_bounds(channel.values) &&
         std::all_of(times.begin(), times.end(), finite);
}

void keep_keys(Channel& channel, const std::vector<size_t>& keys) {
  const Eigen::Index rows = channel.interpolation == Interpolation::CubicSpline ? 3 : 1;  // per key
  const std::vector<double> times = std::exchange(channel.times, {});
  const Rows values = channel.values;
  channel.values.resize(Eigen::Index(keys.size()) * rows, values.cols());
  for (size_t k = 0; k < keys.size(); ++k) {
    channel.times.push_back(times[keys[k]]);
    channel.values.middleRows(Eigen::Index(k) * rows, rows) =
        values.middleRows(Eigen::Index(keys[k]) * rows, rows);
  }
}

void repair_clips(Character& character, Warnings& warnings) {
  for (Clip& clip : character.clips) {
    const auto drop = [&](WarningCode code, const auto& is_wrong) {
      warn(warnings, {code, clip.name, std::int64_t(std::erase_if(clip.channels, is_wrong)), "left out"});
    };
    drop(WarningCode::ClipChannelsUnbound, [&](const Channel& channel) {
      return channel.node < 0 || channel.node >= int(character.skeleton.nodes.size());
    });
    drop(WarningCode::ClipValuesNotFinite, [](const Channel& channel) { return !is_sound(channel); });
    std::set<std::pair<int, Path>> moved;
    drop(WarningCode::ClipChannelsTwice,
         [&](const Channel& channel) { return !moved.emplace(channel.node, channel.path).second; });
    std::int64_t unsorted = 0, coincident = 0;
    for (Channel& channel : clip.channels) {
      const std::vector<size_t> keys = keys_in_order(channel.times);
      unsorted += !std::is_sorted(channel.times.begin(), channel.times.end());
      coincident += std::int64_t(channel.times.size() - keys.size());
      keep_keys(channel, keys);
    }
    warn(warnings, {WarningCode::ClipKeysUnsorted, clip.name, unsorted, "sorted by time"});
    warn(warnings, {WarningCode::ClipKeysCoincide, clip.name, coincident, "the last of them kept"});
  }
}

void note_unused_joints(const Character& character, Warnings& warnings) {
  const Surface& surface = character.surface;
  std::vector<bool> used(character.skeleton.joints.size(), false);
  for (const int w : surface.corners) {
    for (const Influence& i : surface.influences[surface.wedges[w].vertex]) used[i.joint] = true;
  }
  warn(warnings, {WarningCode::JointUnused, "", std::count(used.begin(), used.end(), false), "kept"});
}

// Names of which a joint's node has one and another node the same.
void note_name_clashes(const Skeleton& skeleton, Warnings& warnings) {
  struct Bearers {
    std::int64_t nodes = 0;
    bool joint = false;
  };
  std::vector<bool> joint(skeleton.nodes.size(), false);
  for (const Joint& j : skeleton.joints) joint[j.node] = true;
  std::map<std::string, Bearers> by_name;
  for (size_t n = 0; n < skeleton.nodes.size(); ++n) {
    Bearers& bearers = by_name[skeleton.nodes[n].name];
    ++bearers.nodes;
    bearers.joint = bearers.joint || joint[n];
  }
  by_name.erase("");
  for (const auto& [its, bearers] : by_name) {
    if (!bearers.joint || bearers.nodes < 2) continue;
    warnings.push_back(
        {WarningCode::JointNameClash, its, bearers.nodes - 1, "clips bound by name take the first"});
  }
}

}  // namespace

std::vector<size_t> keys_in_order(std::span<const double> times) {
  std::vector<size_t> keys(times.size());
  std::iota(keys.begin(), keys.end(), size_t(0));
  std::stable_sort(keys.begin(), keys.end(), [&](size_t a, size_t b) { return times[a] < times[b]; });
  size_t kept = 0;
  for (size_t k = 0; k < keys.size(); ++k) {
    if (k + 1 == keys.size() || float(times[keys[k]]) < float(times[keys[k + 1]])) keys[kept++] = keys[k];
  }
  keys.resize(kept);
  return keys;
}

Warnings repair(Character& character) {
  check_skeleton(character);
  SurfaceRepair surface(character);
  surface.repair_positions();
  surface.repair_attributes();
  surface.repair_influences();
  surface.repair_faces();
  Warnings warnings = surface.warnings();
  repair_clips(character, warnings);
  note_unused_joints(character, warnings);
  note_name_clashes(character.skeleton, warnings);
  return warnings;
}

}  // namespace skinlod
