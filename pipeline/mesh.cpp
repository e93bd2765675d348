// SPDX-License-Identifier: MIT
#include "pipeline/mesh.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

#include "pipeline/charts.h"
#include "pipeline/facets.h"
#include "pipeline/morphs.h"
#include "pipeline/parallel.h"

namespace skinlod {
namespace {

bool contains(std::span<const int> items, int item) {
  return std::find(items.begin(), items.end(), item) != items.end();
}

void sort_unique(std::vector<int>& items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

// Keeps the list ascending and each item once. Lists around a vertex are too short for anything cleverer.
template <class List>
void insert(List& list, int item) {
  if (!list.empty() && list.front() == item) return;
  const auto at = std::lower_bound(list.begin(), list.end(), item) - list.begin();
  if (at < std::ptrdiff_t(list.size()) && list[size_t(at)] == item) return;
  list.push_back(item);
  std::rotate(list.begin() + at, list.end() - 1, list.end());
}

constexpr Edge kGone = {-1, -1};

// Which vertices an edge may join, by what the kept end is and what the removed one.
enum class May { Always, AlongALine, Never };
constexpr May kMay[3][3] = {
    //             Inner        Singular         Locked, removed
    /* Inner    */ {May::Always, May::Always, May::Never},
    /* Singular */ {May::Always, May::AlongALine, May::Never},
    /* Locked   */ {May::Always, May::AlongALine, May::Never},
};

// What has come together counts as one side of a surface where its vector area is this much of its area; a
// finger that ends in one vertex has no side.
constexpr double kOneSided = 0.5;

}  // namespace

std::string_view text(Refusal refusal) {
  switch (refusal) {
    case Refusal::None:
      return "none";
    case Refusal::Link:
      return "would fold the surface or change its topology";
    case Refusal::Border:
      return "would join two borders or non-manifold lines";
    case Refusal::Locked:
      return "would move a locked border";
    case Refusal::Seam:
      return "would tear a material seam";
  }
  return "";
}

Mesh::Mesh(const Surface& surface, Borders borders) : position(surface.position), source_(surface) {
  const auto add = [&](std::span<const int> wedges) {
    Face face{.vertex = {}, .wedge = {}, .edge = {}, .corners = int(wedges.size())};
    for (size_t i = 0; i < wedges.size(); ++i) {
      face.wedge[i] = wedges[i];
      face.vertex[i] = surface.wedges[wedges[i]].vertex;
    }
    faces_.push_back(face);
  };
  for (int f = 0; f < surface.face_count(); ++f) {
    const auto wedges = surface.face(f);
    if (wedges.size() <= 4) {
      add(wedges);
    } else {
      for (size_t i = 2; i < wedges.size(); ++i) add(std::array{wedges[0], wedges[i - 1], wedges[i]});
    }
  }
  around_.resize(position.size());
  for (const Face& face : faces_) {
    for (int i = 0; i < face.corners; ++i) ++around_[face.vertex[i]].count;
    triangles_ += face.corners - 2;
  }
  int slots = 0;
  for (Run& run : around_) run.begin = std::exchange(slots, slots + run.count), run.count = 0;
  pool_.resize(size_t(slots)), wedge_pool_.resize(size_t(slots));
  for (int f = 0; f < face_slots(); ++f) {
    for (int i = 0; i < faces_[f].corners; ++i) {
      Run& run = around_[faces_[f].vertex[i]];
      const int at = run.begin + run.count++;
      pool_[at] = f, wedge_pool_[at] = faces_[f].wedge[i];
    }
  }
  in_parallel({[&] { shading_ = shading_quadrics(surface); }, [&] { number_edges(), find_kinds(borders); },
               [&] { find_sheets(), texture_ = texture_quadrics(surface, sheet_); },
               [&] {
                 find_patches();
                 for (const Wedge& wedge : surface.wedges) part_.push_back(wedge.part);
                 flat_ = flat_wedges(surface);
               }});
}

// By ascending ends.
void Mesh::number_edges() {
  struct Side {
    int to, face, corner;
  };
  std::vector<Side> sides;
  for (int v = 0; v < vertex_count(); ++v) {
    sides.clear();
    for (const int f : faces_around(v)) {
      const Face& its = faces_[f];
      const int at = its.corner_of(v);
      if (const int to = its.vertex[its.after(at)]; to > v) sides.push_back({to, f, at});
      if (const int to = its.vertex[its.before(at)]; to > v) sides.push_back({to, f, its.before(at)});
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.to < b.to; });
    int last = -1;
    for (const Side& side : sides) {
      if (std::exchange(last, side.to) != side.to) edges_.push_back({v, side.to});
      faces_[side.face].edge[side.corner] = edge_slots() - 1;
    }
  }
  edge_count_ = edge_slots();
}

void Mesh::find_patches() {
  patch_.resize(position.size());
  for (const Face& face : faces_) {
    for (int i = 0; i < face.corners; ++i) {
      const Vec3& x = position[face.vertex[i]];
      const Vec3& a = position[face.vertex[face.after(i)]];
      const Vec3& b = position[face.vertex[face.before(i)]];
      const Vec3 n = (a - x).cross(b - x);
      patch_[face.vertex[i]] += {n, n.norm()};
    }
  }
}

void Mesh::find_sheets() {
  std::vector<int> lowest;  // sheets are numbered by their first wedges
  for (const int sheet : sheets(source_)) {
    if (sheet == int(lowest.size())) lowest.push_back(int(sheet_.size()));
    sheet_.push_back(lowest[sheet]);
  }
}

void Mesh::find_kinds(Borders borders) {
  // The faces of each edge, as many as a regular one has.
  struct Faces {
    int count = 0;
    std::array<int, 2> first{};
  };
  std::vector<Faces> beside(edges_.size());
  for (int f = 0; f < face_slots(); ++f) {
    for (int i = 0; i < faces_[f].corners; ++i) {
      Faces& its = beside[faces_[f].edge[i]];
      if (its.count < 2) its.first[its.count] = f;
      ++its.count;
    }
  }
  kind_.assign(position.size(), Kind::Inner);
  for (int e = 0; e < edge_slots(); ++e) {
    const bool border =
        beside[e].count == 1 ||
        on_border(beside[e].count == 2 ? beside[e].first : std::span<const int>(faces_of(edges_[e])));
    if (!border && beside[e].count == 2) continue;
    const Kind its = border && borders == Borders::Locked ? Kind::Locked : Kind::Singular;
    for (const int v : {edges_[e].kept, edges_[e].removed}) kind_[v] = std::max(kind_[v], its);
  }
  for (int v = 0; v < vertex_count(); ++v) {
    if (kind_[v] != Kind::Inner || !alive(v)) continue;
    // Every edge is regular: walk around one fan, and see whether it was all.
    int walked = 0;
    const int start = faces_around(v).front();
    int face = start, across = faces_[face].edge[faces_[face].corner_of(v)];
    do {
      const auto& two = beside[across].first;
      face = two[0] == face ? two[1] : two[0];
      const int at = faces_[face].corner_of(v);
      const int out = faces_[face].edge[at], in = faces_[face].edge[faces_[face].before(at)];
      across = in == across ? out : in;
      ++walked;
    } while (face != start && walked <= around_[v].count);
    if (walked != around_[v].count) kind_[v] = Kind::Singular;
  }
}

bool Mesh::on_border(std::span<const int> faces_of_edge) const {
  if (faces_of_edge.empty()) return false;
  const auto first = face(faces_of_edge.front());
  return std::ranges::all_of(faces_of_edge.subspan(1), [&](int f) {
    const auto in_first = [&](int v) { return contains(first, v); };
    return face(f).size() == first.size() && std::ranges::all_of(face(f), in_first);
  });
}

std::vector<Edge> Mesh::edges() const {
  std::vector<Edge> edges;
  for (const Edge e : edges_) {
    if (e.kept >= 0) edges.push_back({std::min(e.kept, e.removed), std::max(e.kept, e.removed)});
  }
  const auto ends = [](Edge e) { return std::pair(e.kept, e.removed); };
  std::ranges::sort(edges, {}, ends);
  return edges;
}

Mesh::Few Mesh::edges_around(int vertex) const {
  Few result;
  for (const int f : faces_around(vertex)) {
    const Face& its = faces_[f];
    const int at = its.corner_of(vertex);
    result.push_back(its.edge[at]), result.push_back(its.edge[its.before(at)]);
  }
  return result;
}

Mesh::Few Mesh::neighbours(int vertex) const {
  Few result;
  for (const int f : faces_around(vertex)) {
    const Face& its = faces_[f];
    const int at = its.corner_of(vertex);
    insert(result, its.vertex[its.before(at)]), insert(result, its.vertex[its.after(at)]);
  }
  return result;
}

// Faces are far apart in memory, and lists of them are not: those that have one end alone are not looked at.
Mesh::Few Mesh::faces_of(Edge edge) const {
  Few with_both, result;
  std::ranges::set_intersection(faces_around(edge.removed), faces_around(edge.kept),
                                std::back_inserter(with_both));
  for (const int f : with_both) {
    if (faces_[f].has(edge)) result.push_back(f);
  }
  return result;
}

bool Mesh::on_seam(Edge edge) const {
  const auto faces = faces_of(edge);
  if (faces.size() != 2) return false;
  const Face &a = faces_[faces[0]], &b = faces_[faces[1]];
  return sheet_[a.wedge_at(edge.kept)] != sheet_[b.wedge_at(edge.kept)] ||
         sheet_[a.wedge_at(edge.removed)] != sheet_[b.wedge_at(edge.removed)];
}

// The wedges that face each other along the edge.
Mesh::WedgePairs Mesh::pairs_along(Edge edge) const {
  WedgePairs pairs;
  for (const int f : faces_of(edge))
    pairs.push_back({faces_[f].wedge_at(edge.removed), faces_[f].wedge_at(edge.kept)});
  return pairs;
}

// True where each chart at the removed end, sheet or material, has one continuation at the kept end, for its
// faces to take their attributes from.
bool Mesh::continues(Edge edge, const WedgePairs& pairs, const auto& charts) const {
  for (const WedgePair& a : pairs) {
    for (const WedgePair& b : pairs) {
      if (sheet_[a.removed] == sheet_[b.removed] && sheet_[a.kept] != sheet_[b.kept]) return false;
    }
  }
  return std::ranges::all_of(wedges_around(edge.removed), [&](int wedge) {
    return std::any_of(pairs.begin(), pairs.end(),
                       [&](const WedgePair& p) { return charts[p.removed] == charts[wedge]; });
  });
}

Refusal Mesh::refusal(Edge edge) const {
  const int kept = edge.kept, removed = edge.removed;
  const auto shared = faces_of(edge);
  if (shared.empty()) return Refusal::Link;
  switch (kMay[size_t(kind_[kept])][size_t(kind_[removed])]) {
    case May::Never:
      return Refusal::Locked;
    case May::AlongALine:
      if (shared.size() == 2 && !on_border(edge)) return Refusal::Border;
      break;
    case May::Always:
      break;
  }

  // The link condition (Dey, Edelsbrunner, Guha, Nekhayev 1999): what both ends touch, the edge's own
  // triangles must touch.
  Few apexes;
  size_t dying = 0;
  for (const int f : shared) {
    if (faces_[f].corners != 3) continue;
    ++dying;
    for (const int v : face(f)) {
      if (v != kept && v != removed) insert(apexes, v);
    }
  }
  // Nearly all that is not near the kept end is told by a hash of its neighbours.
  std::uint64_t near = 0;
  const auto bit = [](int v) { return std::uint64_t(1) << (v & 63); };
  for (const int g : faces_around(kept)) {
    for (const int v : face(g)) near |= bit(v);
  }
  for (const int f : faces_around(removed)) {
    const Face& its = faces_[f];
    const int at = its.corner_of(removed);
    for (const int v : {its.vertex[its.before(at)], its.vertex[its.after(at)]}) {
      if (!(near & bit(v)) || v == kept || contains(apexes, v)) continue;
      const auto meets = [&](int g) { return faces_[g].has({kept, v}); };
      if (std::ranges::any_of(faces_around(kept), meets)) return Refusal::Link;
    }
    const bool has_edge = contains(shared, f);
    if (has_edge && its.corners == 3) continue;
    if (!has_edge && contains(face(f), kept)) return Refusal::Link;  // the ends face each other across a quad
    // A face over two apexes would come to lie on the kept end's face over the same two, and so would what is
    // left of a quad.
    const auto is_near = [&](int v) { return v == removed || (near & bit(v)); };
    if (!std::ranges::all_of(face(f), is_near)) continue;
    for (const int g : faces_around(kept)) {
      if (has_edge && contains(shared, g)) continue;  // what lies on it now may go on doing so
      const auto twin = [&](int v) { return v == removed || contains(face(g), v); };
      if (std::ranges::all_of(face(f), twin)) return Refusal::Link;
    }
  }
  // Nobody may lose the last face: a component never disappears.
  if (size_t(around_[kept].count + around_[removed].count) <= shared.size() + dying) return Refusal::Link;
  if (strands_a_vertex(edge, shared)) return Refusal::Link;
  return continues(edge, pairs_along(edge), part_) ? Refusal::None : Refusal::Seam;
}

bool Mesh::strands_a_vertex(Edge edge, const Few& faces_of_edge) const {
  for (const int f : faces_of_edge) {
    if (faces_[f].corners != 3) continue;
    for (const int v : face(f)) {
      if (v == edge.kept || v == edge.removed) continue;
      if (size_t(around_[v].count) > faces_of_edge.size()) continue;
      const auto dies = [&](int g) { return faces_[g].corners == 3 && contains(faces_of_edge, g); };
      if (std::ranges::all_of(faces_around(v), dies)) return true;
    }
  }
  return false;
}

bool Mesh::stretches_a_chart(Edge edge) const { return !continues(edge, pairs_along(edge), sheet_); }

double Mesh::stretch(Edge edge, const Vec3& to) const {
  const WedgePairs pairs = pairs_along(edge);
  Few alone;
  for (const int wedge : wedges_around(edge.removed)) {
    const int sheet = sheet_[wedge];
    const auto is_it = [&](const WedgePair& p) { return sheet_[p.removed] == sheet; };
    if (std::ranges::none_of(pairs, is_it)) insert(alone, sheet);
  }
  double weight = 0;
  for (const int sheet : alone) weight += texture_.weight(sheet);
  return weight * (to - position[edge.removed]).squaredNorm();
}

// The kept sheet that a wedge at one of the ends will be in; -1: it goes along by itself.
int Mesh::sheet_after(int wedge, const WedgePairs& pairs) const {
  for (const auto& [removed, kept] : pairs) {
    if (sheet_[wedge] == sheet_[kept] || sheet_[wedge] == sheet_[removed]) return sheet_[kept];
  }
  return -1;
}

// What the uvs in two columns become, at `t` between the ends, of a kept sheet and those that come to it: at
// the tip of a seam they are two, and go to their mean.
Vec2 Mesh::joined_uv(const WedgePairs& pairs, int sheet, double t, int at) const {
  const auto uv = [&](int wedge) -> Vec2 { return source_.attributes.row(wedge).segment<2>(at).transpose(); };
  Vec2 kept = Vec2::Zero(), removed = Vec2::Zero();
  int count = 0;
  for (const WedgePair& pair : pairs) {
    if (sheet_[pair.kept] == sheet) kept = uv(pair.kept), removed += uv(pair.removed), ++count;
  }
  return (1 - t) * kept + t * removed / count;
}

// Gives the wedges that are left the attributes of the point at `t` between the ends. Sheets blend as a
// whole, or they would crack in texture space; normals and colours blend only where the two wedges shade the
// same face.
void Mesh::blend_wedges(const Joined& joined) {
  const WedgePairs& pairs = joined.pairs;
  const double t = joined.t;
  const AttributeLayout& layout = source_.layout;
  Rows& attributes = source_.attributes;
  Few wedges;
  for (const int w : wedges_around(joined.edge.kept)) insert(wedges, w);
  for (int set = 0; set < layout.uv_sets; ++set) {
    const int at = layout.uv_at(set);
    std::vector<std::pair<int, Vec2>> after;
    for (const int w : wedges) {
      if (const int to = sheet_after(w, pairs); to >= 0) after.emplace_back(w, joined_uv(pairs, to, t, at));
    }
    for (const auto& [w, uv] : after) attributes.row(w).segment<2>(at) = uv.transpose();
  }

  std::vector<int> done;
  for (const WedgePair& pair : pairs) {
    const int removed = pair.removed, kept = pair.kept;
    if (std::find(done.begin(), done.end(), kept) != done.end()) continue;
    done.push_back(kept);
    const auto blend_unit = [&](int column) {
      const Vec3 sum = (1 - t) * attributes.row(kept).segment<3>(column).transpose() +
                       t * attributes.row(removed).segment<3>(column).transpose();
      if (t > 0 && sum.norm() > 1e-6) attributes.row(kept).segment<3>(column) = sum.normalized().transpose();
    };
    if (layout.normal) blend_unit(layout.normal_at());
    if (layout.tangent) blend_unit(layout.tangent_at());
    const int colour = layout.colour_at(0), colour_size = 4 * layout.colour_sets;
    attributes.row(kept).segment(colour, colour_size) =
        ((1 - t) * attributes.row(kept) + t * attributes.row(removed)).segment(colour, colour_size).eval();
    flat_[kept] = flat_[kept] && flat_[removed];
    if (!source_.normal_morphs.empty()) {
      source_.normal_morphs[kept] =
          skinlod::blend(source_.normal_morphs[kept], source_.normal_morphs[removed], t);
    }
  }
}

// Each removed group once.
Mesh::WedgePairs Mesh::pairs_of_groups(const WedgePairs& pairs, const auto& group) {
  WedgePairs groups;
  for (const auto& [removed, kept] : pairs) {
    const WedgePair pair{group(removed), group(kept)};
    const auto same = [&](const WedgePair& p) { return p.removed == pair.removed; };
    if (std::none_of(groups.begin(), groups.end(), same)) groups.push_back(pair);
  }
  return groups;
}
Mesh::WedgePairs Mesh::pairs_of_wedges(const WedgePairs& pairs) const {
  return pairs_of_groups(pairs, [](int wedge) { return wedge; });
}
Mesh::WedgePairs Mesh::pairs_of_sheets(const WedgePairs& pairs) const {
  return pairs_of_groups(pairs, [&](int wedge) { return sheet_[wedge]; });
}

Quadric Mesh::attribute_error(Edge edge) const {
  WedgePairs pairs = pairs_along(edge);
  if (!continues(edge, pairs, sheet_)) edge = edge.turned(), pairs = pairs_along(edge);
  Few kept_wedges, removed_wedges, kept_sheets, removed_sheets;
  for (const int w : wedges_around(edge.kept)) insert(kept_wedges, w), insert(kept_sheets, sheet_[w]);
  for (const int w : wedges_around(edge.removed))
    insert(removed_wedges, w), insert(removed_sheets, sheet_[w]);
  // Those that are paired go together, the others go along by themselves.
  Quadric sum;
  const auto add = [&](const AttributeQuadrics& of, const Few& kept, const Few& removed,
                       const WedgePairs& merged) {
    for (const int group : kept) {
      Few together;
      together.push_back(group);
      for (const WedgePair& pair : merged) {
        if (pair.kept == group) together.push_back(pair.removed);
      }
      sum += of.error({together.data(), together.size()});
    }
    for (const int group : removed) {
      const auto is_it = [&](const WedgePair& pair) { return pair.removed == group; };
      if (std::none_of(merged.begin(), merged.end(), is_it)) sum += of.error({&group, 1});
    }
  };
  add(shading_, kept_wedges, removed_wedges, pairs_of_wedges(pairs));
  add(texture_, kept_sheets, removed_sheets, pairs_of_sheets(pairs));
  return sum;
}

double Mesh::way_along(Edge edge, const Vec3& to) const {
  if (kind_[edge.kept] == Kind::Locked) return 0;
  const Vec3 along = position[edge.removed] - position[edge.kept];
  const double length = along.squaredNorm();
  return length > 0 ? std::clamp((to - position[edge.kept]).dot(along) / length, 0.0, 1.0) : 0.5;
}

bool Mesh::turns_from_source(Edge edge, const Vec3& to) const {
  Patch both = patch_[edge.kept];
  both += patch_[edge.removed];
  for (const int end : {edge.kept, edge.removed}) {
    for (const int f : faces_around(end)) {
      if (contains(face(f), end == edge.kept ? edge.removed : edge.kept)) continue;
      const Face& its = faces_[f];
      const int i = its.corner_of(end), a = its.vertex[its.after(i)], b = its.vertex[its.before(i)];
      Patch all = both;
      all += patch_[a], all += patch_[b];
      if ((position[a] - to).cross(position[b] - to).dot(all.vector_area) < 0 &&
          all.vector_area.norm() >= kOneSided * all.area)
        return true;
    }
  }
  return false;
}

bool Mesh::turns_a_uv(Edge edge, const Vec3& to) const {
  const AttributeLayout& layout = source_.layout;
  if (layout.uv_sets == 0) return false;
  const WedgePairs pairs = pairs_along(edge);
  const double t = way_along(edge, to);
  const auto before = [&](int wedge, int at) -> Vec2 {
    return source_.attributes.row(wedge).segment<2>(at).transpose();
  };
  const auto after = [&](int wedge, int at) -> Vec2 {
    const int sheet = sheet_after(wedge, pairs);
    return sheet >= 0 ? joined_uv(pairs, sheet, t, at) : before(wedge, at);
  };
  for (const int end : {edge.kept, edge.removed}) {
    for (const int f : faces_around(end)) {
      const Face& its = faces_[f];
      if (contains(face(f), end == edge.kept ? edge.removed : edge.kept)) continue;
      const int i = its.corner_of(end);
      for (int set = 0; set < layout.uv_sets; ++set) {
        const int at = layout.uv_at(set);
        const Vec2 a = before(its.wedge[its.after(i)], at), b = before(its.wedge[its.before(i)], at);
        const auto area = [&](const Vec2& x) {
          return (a - x).x() * (b - x).y() - (a - x).y() * (b - x).x();
        };
        const double was = area(before(its.wedge[i], at));
        if (was != 0 && was * area(after(its.wedge[i], at)) <= 0) return true;
      }
    }
  }
  return false;
}

void Mesh::forget(int vertex, int face) {
  Run& run = around_[vertex];
  const auto first = pool_.begin() + run.begin;
  const auto at = std::find(first, first + run.count, face) - pool_.begin();
  const auto close = [&](std::vector<int>& pool) {
    std::copy(pool.begin() + at + 1, pool.begin() + run.begin + run.count, pool.begin() + at);
  };
  close(pool_), close(wedge_pool_);
  --run.count;
}

// Takes a corner out of a quad, and the side beside it that is gone.
void Mesh::drop_corner(Face& face, int corner) {
  const int before = face.before(corner);
  if (edges_[face.edge[before]] == kGone) face.edge[before] = face.edge[corner];
  const auto close = [&](std::array<int, 4>& of) {
    std::copy(of.begin() + corner + 1, of.end(), of.begin() + corner);
  };
  close(face.vertex), close(face.wedge), close(face.edge);
  face.corners = 3;
}

// Beside the triangles that die two edges become one: that of the kept end. The others go over to it. Returns
// those that stay, unless no other triangle has them.
Mesh::Few Mesh::join_edges(Edge edge, const Few& shared) {
  struct Two {
    int gone, stays;
  };
  ShortList<Two, 4> pairs;
  int dies = 0;
  for (const int f : shared) {
    const Face& its = faces_[f];
    const int k = its.corner_of(edge.kept), r = its.corner_of(edge.removed);
    const bool ahead = its.after(k) == r;
    dies = its.edge[ahead ? k : r];
    if (its.corners == 3)
      pairs.push_back({its.edge[ahead ? r : its.before(r)], its.edge[ahead ? its.before(k) : k]});
  }
  for (const int f : faces_around(edge.removed)) {
    Face& its = faces_[f];
    const int at = its.corner_of(edge.removed);
    for (int* side : {&its.edge[at], &its.edge[its.before(at)]}) {
      for (const Two& pair : pairs) {
        if (*side == pair.gone) *side = pair.stays;
      }
      Edge& e = edges_[*side];
      if (e.kept == edge.removed) e.kept = edge.kept;
      if (e.removed == edge.removed) e.removed = edge.kept;
    }
  }
  Few joined;
  remove_edge(dies);
  for (const Two& pair : pairs) remove_edge(pair.gone), joined.push_back(pair.stays);
  return joined;
}

void Mesh::remove_edge(int number) { edge_count_ -= std::exchange(edges_[number], kGone) != kGone; }

void Mesh::blend(const Joined& joined, const std::optional<MorphOffsets>& morphs) {
  const auto [kept, removed] = joined.edge;
  blend_wedges(joined);
  for (const auto& [gone, stays] : pairs_of_wedges(joined.pairs)) shading_.merge(stays, gone);
  for (const auto& [gone, stays] : pairs_of_sheets(joined.pairs)) texture_.merge(stays, gone);
  for (const int wedge : wedges_around(kept)) {
    if (const int sheet = sheet_after(wedge, joined.pairs); sheet >= 0) sheet_[wedge] = sheet;
    source_.wedges[wedge].vertex = kept;
  }
  patch_[kept] += patch_[removed];
  if (source_.morphs.empty()) return;
  if (kind_[kept] != Kind::Locked)
    source_.morphs[kept] =
        morphs ? *morphs : skinlod::blend(source_.morphs[kept], source_.morphs[removed], joined.t);
  source_.morphs[removed].clear();
}

Mesh::Joined Mesh::join(Edge edge, const Vec3& to) {
  const int kept = edge.kept, removed = edge.removed;
  const WedgePairs pairs = pairs_along(edge);
  const double t = way_along(edge, to);
  const Few joined = join_edges(edge, faces_of(edge));
  Few moved;  // to the kept end, ascending
  for (const int f : faces_around(removed)) {
    Face& face = faces_[f];
    const int at = face.corner_of(removed);
    const int wedge = face.wedge[at];
    if (!contains(this->face(f), kept)) {
      // A wedge that shades one face with a wedge of the kept end goes over into it; others move along.
      const auto partner =
          std::find_if(pairs.begin(), pairs.end(), [&](const WedgePair& p) { return p.removed == wedge; });
      if (partner != pairs.end()) face.wedge[at] = partner->kept;
      face.vertex[at] = kept;
      moved.push_back(f);
      continue;
    }
    --triangles_;
    if (face.corners == 3) {
      for (const int v : this->face(f)) {
        if (v != removed) forget(v, f);
      }
      face.corners = 0;
    } else {
      drop_corner(face, at);
    }
  }
  const auto own = faces_around(kept);
  Few faces;
  std::merge(own.begin(), own.end(), moved.begin(), moved.end(), std::back_inserter(faces));
  around_[kept] = {int(pool_.size()), int(faces.size())};
  around_[removed].count = 0;
  pool_.insert(pool_.end(), faces.begin(), faces.end());
  for (const int f : faces) wedge_pool_.push_back(faces_[f].wedge_at(kept));
  for (const int e : joined) {
    if (edges_[e] != kGone && faces_of(edges_[e]).empty()) remove_edge(e);
  }
  position[kept] = to;
  kind_[kept] = std::max(kind_[kept], kind_[removed]);
  return {edge, t, pairs};
}

void Mesh::collapse(Edge edge, const Vec3& to, const std::optional<MorphOffsets>& morphs) {
  blend(join(edge, to), morphs);
}

Surface Mesh::surface(std::span<const Influences> influences) const {
  Surface out;
  out.layout = source_.layout;
  std::vector<int> new_vertex(position.size(), -1), new_wedge(source_.wedges.size(), -1);
  std::vector<int> wedges;
  for (int v = 0; v < vertex_count(); ++v) {
    if (!alive(v)) continue;
    new_vertex[v] = int(out.position.size());
    out.position.push_back(position[v]);
    out.influences.push_back(influences[v]);
    if (!source_.morphs.empty()) out.morphs.push_back(source_.morphs[v]);
  }
  for (const Face& face : faces_)
    wedges.insert(wedges.end(), face.wedge.begin(), face.wedge.begin() + face.corners);
  sort_unique(wedges);
  out.attributes.resize(Eigen::Index(wedges.size()), source_.attributes.cols());
  std::vector<int> vertex_of(source_.wedges.size(), -1);
  for (const Face& face : faces_) {
    for (int i = 0; i < face.corners; ++i) vertex_of[face.wedge[i]] = face.vertex[i];
  }
  for (const int w : wedges) {
    new_wedge[w] = int(out.wedges.size());
    out.attributes.row(new_wedge[w]) = source_.attributes.row(w);
    out.wedges.push_back({new_vertex[vertex_of[w]], source_.wedges[w].part});
    if (!source_.normal_morphs.empty()) out.normal_morphs.push_back(source_.normal_morphs[w]);
  }
  std::vector<char> flat(wedges.size());
  for (size_t w = 0; w < wedges.size(); ++w) flat[w] = flat_[wedges[w]];
  for (int f = 0; f < face_slots(); ++f) {
    if (faces_[f].corners == 0) continue;
    std::array<int, 4> corners{};
    for (int i = 0; i < faces_[f].corners; ++i) corners[i] = new_wedge[faces_[f].wedge[i]];
    out.add_face({corners.data(), size_t(faces_[f].corners)});
  }
  shade_flat(out, flat);
  return out;
}

std::vector<char> locked_vertices(const Surface& surface, Borders borders) {
  std::vector<char> locked(surface.position.size(), 0);
  if (borders == Borders::Free) return locked;
  const Mesh mesh(surface, borders);
  for (size_t v = 0; v < locked.size(); ++v) locked[v] = mesh.kind(int(v)) == Kind::Locked;
  return locked;
}

}  // namespace skinlod
