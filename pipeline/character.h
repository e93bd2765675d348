// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "pipeline/linalg.h"
#include "pipeline/short_list.h"
#include "pipeline/skeleton.h"

namespace skinlod {

/// A share of a vertex in a joint's motion.
struct Influence {
  int joint;
  double weight;
  friend bool operator==(const Influence&, const Influence&) = default;
};

/// The influences of one vertex, by ascending joint, weights > 0 with sum 1 once repaired.
using Influences = ShortList<Influence, 4>;

/// The offset that one morph target at weight 1 adds, in rest space.
struct MorphOffset {
  int morph;
  Vec3 delta;
};

/// The offsets of one vertex, or of the normal of one wedge, by ascending morph.
using MorphOffsets = std::vector<MorphOffset>;

/// Which columns the attribute table has: normal (3), tangent (3 and handedness), uv sets (2 each),
/// colour sets (rgba each), in this order.
struct AttributeLayout {
  bool normal = false;
  bool tangent = false;
  int uv_sets = 0;
  int colour_sets = 0;

  int normal_at() const { return 0; }
  int tangent_at() const { return 3 * normal; }
  int uv_at(int set) const { return tangent_at() + 4 * tangent + 2 * set; }
  int colour_at(int set) const { return uv_at(uv_sets) + 4 * set; }
  int columns() const { return colour_at(colour_sets); }
  friend bool operator==(const AttributeLayout&, const AttributeLayout&) = default;
};

/// The columns of either.
AttributeLayout joined(const AttributeLayout& a, const AttributeLayout& b);

/// One set of attributes at a vertex; its row in the attribute table has the same index.
struct Wedge {
  int vertex;
  int part;
};

/// Points with influences, wedges with attributes, faces of any number of corners.
/// The form in which geometry travels: import, weld, every level, every writer.
struct Surface {
  std::vector<Vec3> position;               // per vertex, rest space, metres
  std::vector<Influences> influences;       // per vertex
  std::vector<MorphOffsets> morphs;         // per vertex; or empty: none at all
  std::vector<double> importance;           // per vertex, for solving: see importance.h; or empty: all 1
  std::vector<Wedge> wedges;                // wedges of one vertex and part need not be neighbours
  AttributeLayout layout;                   // the union of what the parts have
  Rows attributes;                          // row per wedge; columns a part lacks hold the default
  std::vector<MorphOffsets> normal_morphs;  // per wedge; or empty: none at all
  std::vector<int> corners;                 // wedges, face after face, counter-clockwise
  std::vector<int> face_begin = {0};        // face f has corners face_begin[f] up to face_begin[f + 1]

  int face_count() const { return int(face_begin.size()) - 1; }
  std::span<const int> face(int f) const {
    return std::span(corners).subspan(size_t(face_begin[f]), size_t(face_begin[f + 1] - face_begin[f]));
  }
  int part(int f) const { return wedges[corners[face_begin[f]]].part; }
  void add_face(std::span<const int> wedge) {
    corners.insert(corners.end(), wedge.begin(), wedge.end());
    face_begin.push_back(int(corners.size()));
  }
};

/// The vertices of face `f`, which must be a triangle.
std::array<int, 3> triangle_vertices(const Surface& surface, int f);

/// The number of triangles in the faces' fans: what a GPU draws and what every target counts.
int triangle_count(const Surface& surface);

/// True where every face is a triangle.
bool is_triangulated(const Surface& surface);

/// The same surface with every polygon cut into triangles by clipping ears, the shortest new edge first: a
/// quad along its shorter diagonal, a concave face without a fold. A face of more than 64 corners, or one so
/// warped that it has no ear, becomes a fan from its first corner. Wedges and vertices keep their indices.
Surface triangulated(const Surface& surface);

/// The default of each attribute column: normal +z, tangent +x and handedness 1, uv 0, colour white.
Eigen::RowVectorXd default_attributes(const AttributeLayout& layout);

/// The table over the columns of `to`, which has all of `from`; new ones hold their default.
Rows widened(const Rows& table, const AttributeLayout& from, const AttributeLayout& to);

/// A run of faces that is drawn with one material: a glTF primitive at one node.
struct Part {
  std::string name;
  int node = -1;             // the node that carries the mesh
  int material = -1;         // in Character::materials, or -1
  AttributeLayout has = {};  // what the file gave; writers put out no more
};

/// Enough of a material to recognise the character; a glTF source keeps its own in full.
struct Material {
  std::string name;
  Vec4 base_colour = Vec4::Ones();  // linear rgba
  std::string texture = {};         // the base colour image's path as the file has it; may be empty
  bool double_sided = false;
};

/// A morph target of the mesh at `node`.
struct Morph {
  std::string name;
  int node = -1;
  double weight = 0;  // at rest
};

enum class Interpolation { Step, Linear, CubicSpline };
enum class Path { Translation, Rotation, Scale, MorphWeights };

/// The motion of one property of one node.
struct Channel {
  int node;
  Path path;
  Interpolation interpolation;
  std::vector<double> times;  // seconds, ascending
  Rows values;                // row per key; for CubicSpline three: in-tangent, value, out-tangent
};

struct Clip {
  std::string name;
  std::vector<Channel> channels;
  double duration() const;  // seconds: the last time of any channel
};

/// A rigged character. As imported every render vertex is a vertex with one wedge; `weld` joins them.
struct Character {
  std::string name;
  Skeleton skeleton;
  std::vector<Clip> clips;
  std::vector<Material> materials;
  std::vector<Part> parts;
  std::vector<Morph> morphs;
  Surface surface;
};

/// The length of the diagonal of the box around all rest positions, metres: the size errors are compared
/// with.
double diagonal(std::span<const Vec3> positions);

}  // namespace skinlod
