// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/attribute_quadrics.h"
#include "pipeline/character.h"
#include "pipeline/importance.h"
#include "pipeline/short_list.h"

namespace skinlod {

/// Two neighbours. A collapse of the edge removes one end and moves the other:
///
///        a                     a
///      / | \                 / | \                                                     .
///  ..kept-removed..   -->  ..kept ..      the faces that hold both ends lose a corner;
///      \ | /                 \ | /        a triangle is gone, a quad becomes a triangle
///        b                     b
struct Edge {
  int kept;
  int removed;
  Edge turned() const { return {removed, kept}; }
  friend bool operator==(const Edge&, const Edge&) = default;
};

/// Why an edge must not be collapsed.
enum class Refusal {
  None,
  Link,    // the surface would fold onto itself, change its genus, lose a border or a whole component
  Border,  // both ends are on singular lines (borders, edges of three and more faces), the edge is not
  Locked,  // the removed end is locked
  Seam,    // the removed end has materials that do not continue at the kept end
};
std::string_view text(Refusal refusal);

/// What a vertex is to the surface around it.
enum class Kind : char {
  Inner,     // in the middle of one closed fan of faces
  Singular,  // on a border, on an edge of three or more faces, or where fans meet in a point
  Locked,    // on a border that is locked: stays where it is, as it is
};

/// Whether what lies on open borders may change. Locked, surfaces that are simplified apart and meet there
/// still meet.
enum class Borders { Free, Locked };

/// Editable connectivity of triangles and quads over the vertices and wedges of a Surface.
///
/// Wedges of a vertex that agree in part and uvs are one *sheet*: a continuous chart of texture around the
/// vertex. An edge is on a *seam* where its two faces lie in different sheets. Wedges of one sheet that
/// differ (hard edges, facets, painted faces) differ in normals and colours alone; those move along and are
/// never a reason to stop.
///
/// Charts of texture keep their outlines as long as that costs less than letting them stretch. Where they are
/// many and small that is not long. Materials always keep theirs.
class Mesh {
 public:
  /// Of the faces and vertices around a vertex there are seldom more.
  using Few = ShortList<int, 16>;

  /// Faces of more than four corners are cut into triangles.
  explicit Mesh(const Surface& surface, Borders borders = Borders::Free);

  std::vector<Vec3> position;  // per vertex, rest space

  /// What is drawn: triangles, and two for each quad.
  int triangle_count() const { return triangles_; }
  int vertex_count() const { return int(position.size()); }
  bool alive(int vertex) const { return around_[vertex].count > 0; }

  /// Corners of a face as vertices: 3 or 4; none where the face is gone.
  std::span<const int> face(int f) const { return {faces_[f].vertex.data(), size_t(faces_[f].corners)}; }
  int face_slots() const { return int(faces_.size()); }
  /// Ascending.
  std::span<const int> faces_around(int vertex) const {
    return std::span(pool_).subspan(size_t(around_[vertex].begin), size_t(around_[vertex].count));
  }

  /// What each of these faces has at the vertex, in their order.
  std::span<const int> wedges_around(int vertex) const {
    return std::span(wedge_pool_).subspan(size_t(around_[vertex].begin), size_t(around_[vertex].count));
  }

  /// Edges keep their numbers as long as they are there, whatever vertices their ends become. Both -1 for one
  /// that is gone: collapsed, or come to lie on another.
  Edge edge(int number) const { return edges_[number]; }
  int edge_slots() const { return int(edges_.size()); }
  int edge_count() const { return edge_count_; }

  /// The numbers of the edges at a vertex, some of them twice.
  Few edges_around(int vertex) const;

  /// All edges that are there, by ascending ends, `kept` the lower.
  std::vector<Edge> edges() const;

  /// The vertices that share an edge with `vertex`, ascending.
  Few neighbours(int vertex) const;

  /// How many faces have the edge, and the sides they see it from.
  Few faces_of(Edge edge) const;

  /// True where the edge's two faces lie in different sheets at either end.
  bool on_seam(Edge edge) const;

  /// True where the edge's faces, one or more, all lie on one side of it: an open border, or the outline of a
  /// card that has faces on its back too.
  bool on_border(Edge edge) const { return on_border(faces_of(edge)); }
  bool on_border(std::span<const int> faces_of_edge) const;

  Kind kind(int vertex) const { return kind_[vertex]; }

  /// Whether `edge` may be collapsed in this direction, as far as connectivity and seams can tell.
  Refusal refusal(Edge edge) const;

  /// What of that may change although no face at either end has changed: true where a vertex beside the edge
  /// loses its last face.
  bool strands_a_vertex(Edge edge) const { return strands_a_vertex(edge, faces_of(edge)); }

  /// What a collapse of the edge, in the direction in which its seams continue, does to normals, uvs and
  /// colours, as a function of where the kept vertex goes: wedges that come together share what is best for
  /// all. m^4, as for positions.
  Quadric attribute_error(Edge edge) const;

  /// What it costs that sheets which do not continue at the kept end go there with the uvs that they have, as
  /// the kept end goes to `to`: m^4, for one pose; 0 where all continue.
  double stretch(Edge edge, const Vec3& to) const;

  /// Whether there are such sheets.
  bool stretches_a_chart(Edge edge) const;

  /// True where collapsing the edge to `to` turns a surviving face away from what its corners stand for: the
  /// faces of the source that have come together there. Many small turns make a fold that none of them is.
  bool turns_from_source(Edge edge, const Vec3& to) const;

  /// True where collapsing the edge, which must not be refused, to `to` turns a surviving triangle over in
  /// one of the uv sets, or flattens it.
  bool turns_a_uv(Edge edge, const Vec3& to) const;

  /// What squared errors on a face or an edge with these ends count as: see importance.h.
  double error_weight(std::span<const int> ends) const { return skinlod::error_weight(source_, ends); }

  /// The morph offsets of a vertex.
  std::span<const MorphOffset> morphs(int vertex) const {
    return source_.morphs.empty() ? std::span<const MorphOffset>() : source_.morphs[vertex];
  }

  /// How far along the edge its closest point to `to` is: 0 at the kept end, 1 at the removed one.
  double way_along(Edge edge, const Vec3& to) const;

  /// Collapses the edge, which must not be refused, and moves the kept vertex to `to`. Attributes and, unless
  /// `morphs` are given, morph offsets are those of the point of the old edge that is closest to `to`; unit
  /// vectors stay unit. Those of a locked vertex stay to the last bit.
  void collapse(Edge edge, const Vec3& to, const std::optional<MorphOffsets>& morphs = {});

  /// The same in two parts. Before an edge beside it is looked at, what is joined must be blended; what is
  /// not beside each other may be blended in parallel.
  struct Joined;
  Joined join(Edge edge, const Vec3& to);
  void blend(const Joined& joined, const std::optional<MorphOffsets>& morphs = {});

  /// What is left, with `influences` (of all vertices this mesh began with) for its points. Unused vertices
  /// and wedges are left out. Normals that were those of their faces in the source are so again.
  Surface surface(std::span<const Influences> influences) const;

 private:
  struct alignas(64) Face {  // a cache line
    std::array<int, 4> vertex;
    std::array<int, 4> wedge;
    std::array<int, 4> edge;  // from each corner to the next
    int corners;              // 0: gone
    int corner_of(int v) const {
      int corner = 0;
      while (vertex[corner] != v) ++corner;
      return corner;
    }
    int wedge_at(int v) const { return wedge[corner_of(v)]; }
    int before(int corner) const { return corner == 0 ? corners - 1 : corner - 1; }
    int after(int corner) const { return corner == corners - 1 ? 0 : corner + 1; }
    bool has(Edge e) const {
      for (int i = 0; i < corners; ++i) {
        if (vertex[i] != e.kept) continue;
        if (vertex[after(i)] == e.removed || vertex[before(i)] == e.removed) return true;
      }
      return false;
    }
  };
  struct WedgePair {
    int removed, kept;
  };
  using WedgePairs = ShortList<WedgePair, 4>;
  struct Run {
    int begin = 0, count = 0;
  };

  // The faces of the source that a vertex stands for, each as often as it has corners there, at rest.
  struct Patch {
    Vec3 vector_area = Vec3::Zero();  // twice; m^2
    double area = 0;                  // twice
    Patch& operator+=(const Patch& p) {
      vector_area += p.vector_area, area += p.area;
      return *this;
    }
  };

  WedgePairs pairs_along(Edge edge) const;
  bool strands_a_vertex(Edge edge, const Few& faces_of_edge) const;
  bool continues(Edge edge, const WedgePairs& pairs, const auto& charts) const;
  static WedgePairs pairs_of_groups(const WedgePairs& pairs, const auto& group);
  WedgePairs pairs_of_wedges(const WedgePairs& pairs) const;
  WedgePairs pairs_of_sheets(const WedgePairs& pairs) const;
  int sheet_after(int wedge, const WedgePairs& pairs) const;
  Vec2 joined_uv(const WedgePairs& pairs, int sheet, double t, int at) const;
  void blend_wedges(const Joined& joined);
  void forget(int vertex, int face);  // from the faces around it
  void drop_corner(Face& face, int corner);
  Few join_edges(Edge edge, const Few& shared);
  void remove_edge(int number);
  void number_edges();
  void find_patches();
  void find_sheets();
  void find_kinds(Borders borders);

  Surface source_;  // attributes, morphs and layout of the surviving wedges and vertices; faces are stale
  std::vector<Face> faces_;
  std::vector<Edge> edges_;
  std::vector<Run> around_;      // per vertex: where its faces stand in the pool
  std::vector<int> pool_;        // a collapse appends the kept vertex's new faces; the old are left behind
  std::vector<int> wedge_pool_;  // the wedge of each there
  std::vector<int> sheet_;       // per wedge: the lowest wedge of its sheet
  std::vector<int> part_;        // per wedge
  std::vector<char> flat_;       // per wedge: its normal is that of its faces
  std::vector<Kind> kind_;       // per vertex
  std::vector<Patch> patch_;     // per vertex
  AttributeQuadrics shading_;    // by wedge
  AttributeQuadrics texture_;    // by the lowest wedge of the sheet
  int edge_count_ = 0;
  int triangles_ = 0;
};

struct Mesh::Joined {
  Edge edge;
  double t;          // how far along it the point is that attributes are taken from
  WedgePairs pairs;  // that met along it
};

/// Per vertex of a surface whether it is locked; none is where borders are free.
std::vector<char> locked_vertices(const Surface& surface, Borders borders);

}  // namespace skinlod
