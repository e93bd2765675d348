// SPDX-License-Identifier: MIT
#include "pipeline/mesh.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "pipeline/facets.h"
#include "pipeline/morphs.h"

namespace skinlod {
namespace {

// The two vertices beside `v` along the face's outline.
std::array<int, 2> beside(std::span<const int> face, int v) {
  const size_t n = face.size();
  const size_t i = size_t(std::find(face.begin(), face.end(), v) - face.begin());
  return {face[(i + n - 1) % n], face[(i + 1) % n]};
}

bool contains(std::span<const int> face, int v) {
  return std::find(face.begin(), face.end(), v) != face.end();
}

bool has_edge(std::span<const int> face, Edge e) {
  for (size_t i = 0, before = face.size() - 1; i < face.size(); before = i++) {
    if (face[i] == e.kept && face[before] == e.removed) return true;
    if (face[i] == e.removed && face[before] == e.kept) return true;
  }
  return false;
}

void sort_unique(std::vector<int>& items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

// Keeps the list ascending and each item once. Lists around a vertex are too short for anything cleverer.
template <class List>
void insert(List& list, int item) {
  const auto at = std::lower_bound(list.begin(), list.end(), item) - list.begin();
  if (at < std::ptrdiff_t(list.size()) && list[size_t(at)] == item) return;
  list.push_back(item);
  std::rotate(list.begin() + at, list.end() - 1, list.end());
}

// Which vertices an edge may join, by what the kept end is and what the removed one.
enum class May { Always, AlongALine, Never };
constexpr May kMay[3][3] = {
    //             Inner        Singular         Locked, removed
    /* Inner    */ {May::Always, May::Always, May::Never},
    /* Singular */ {May::Always, May::AlongALine, May::Never},
    /* Locked   */ {May::Always, May::AlongALine, May::Never},
};

bool same_sheet(const Surface& s, int a, int b) {
  const int from = s.layout.uv_at(0), size = 2 * s.layout.uv_sets;
  return s.wedges[a].part == s.wedges[b].part &&
         s.attributes.row(a).segment(from, size) == s.attributes.row(b).segment(from, size);
}

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

int Mesh::Face::wedge_at(int v) const {
  for (int i = 0; i < corners; ++i) {
    if (vertex[i] == v) return wedge[i];
  }
  return -1;
}

Mesh::Mesh(const Surface& surface, Borders borders) : position(surface.position), source_(surface) {
  const auto add = [&](std::span<const int> wedges) {
    Face face{.vertex = {}, .wedge = {}, .corners = int(wedges.size())};
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
  pool_.resize(size_t(slots));
  for (int f = 0; f < face_slots(); ++f) {
    for (const int v : face(f)) pool_[around_[v].begin + around_[v].count++] = f;
  }

  // Per vertex, the wedges that are the first of their sheets, as a linked list.
  std::vector<int> first(position.size(), -1), next(surface.wedges.size(), -1);
  sheet_.resize(surface.wedges.size());
  for (int w = 0; w < int(surface.wedges.size()); ++w) {
    int* other = &first[surface.wedges[w].vertex];
    while (*other >= 0 && !same_sheet(surface, *other, w)) other = &next[*other];
    if (*other < 0) *other = w;
    sheet_[w] = *other;
  }

  for (const Wedge& wedge : surface.wedges) part_.push_back(wedge.part);
  flat_ = flat_wedges(surface);
  shading_ = shading_quadrics(surface), texture_ = texture_quadrics(surface, sheet_);
  find_kinds(borders);
}

void Mesh::find_kinds(Borders borders) {
  kind_.assign(position.size(), Kind::Inner);
  for (const Edge e : edges()) {
    const bool border = on_border(e);
    if (!border && faces_of(e).size() == 2) continue;
    const Kind its = border && borders == Borders::Locked ? Kind::Locked : Kind::Singular;
    for (const int v : {e.kept, e.removed}) kind_[v] = std::max(kind_[v], its);
  }
  for (int v = 0; v < vertex_count(); ++v) {
    if (kind_[v] != Kind::Inner || !alive(v)) continue;
    // Every edge is regular: walk around one fan, and see whether it was all.
    size_t walked = 0;
    const int start = faces_around(v).front();
    int face = start, to = beside(this->face(face), v)[1];
    do {
      const auto two = faces_of({v, to});
      face = two[0] == face ? two[1] : two[0];
      const auto [before, after] = beside(this->face(face), v);
      to = before == to ? after : before;
      ++walked;
    } while (face != start && walked <= faces_around(v).size());
    if (walked != faces_around(v).size()) kind_[v] = Kind::Singular;
  }
}

bool Mesh::on_border(Edge edge) const {
  const auto faces = faces_of(edge);
  if (faces.empty()) return false;
  const auto first = face(faces.front());
  return std::all_of(faces.begin(), faces.end(), [&](int f) {
    return std::is_permutation(first.begin(), first.end(), face(f).begin(), face(f).end());
  });
}

std::vector<Edge> Mesh::edges() const {
  std::vector<Edge> edges;
  for (int v = 0; v < vertex_count(); ++v) {
    for (const int u : neighbours(v)) {
      if (u > v) edges.push_back({v, u});
    }
  }
  return edges;
}

Mesh::Few Mesh::neighbours(int vertex) const {
  Few result;
  for (const int f : faces_around(vertex)) {
    for (const int v : beside(face(f), vertex)) insert(result, v);
  }
  return result;
}

Mesh::Few Mesh::faces_of(Edge edge) const {
  Few result;
  for (const int f : faces_around(edge.removed)) {
    if (has_edge(face(f), edge)) result.push_back(f);
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
bool Mesh::continues(Edge edge, const auto& charts) const {
  const WedgePairs pairs = pairs_along(edge);
  for (const WedgePair& a : pairs) {
    for (const WedgePair& b : pairs) {
      if (sheet_[a.removed] == sheet_[b.removed] && sheet_[a.kept] != sheet_[b.kept]) return false;
    }
  }
  return std::ranges::all_of(faces_around(edge.removed), [&](int f) {
    const int wedge = faces_[f].wedge_at(edge.removed);
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
  const Few a = neighbours(kept), b = neighbours(removed);
  Few common;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
  if (!std::ranges::equal(common, apexes)) return Refusal::Link;

  for (const int f : faces_around(removed)) {
    const auto vertices = face(f);
    if (std::find(shared.begin(), shared.end(), f) != shared.end()) continue;
    if (contains(vertices, kept)) return Refusal::Link;  // the ends face each other across a quad
    // A face over two apexes would come to lie on the kept end's face over the same two.
    for (const int g : faces_around(kept)) {
      const auto twin = [&](int v) { return v == removed || contains(face(g), v); };
      if (std::all_of(vertices.begin(), vertices.end(), twin)) return Refusal::Link;
    }
  }
  // Nobody may lose the last face: a component never disappears.
  if (size_t(around_[kept].count + around_[removed].count) <= shared.size() + dying) return Refusal::Link;
  for (const int v : apexes) {
    const auto dies = [&](int f) { return faces_[f].corners == 3 && has_edge(face(f), edge); };
    if (std::ranges::all_of(faces_around(v), dies)) return Refusal::Link;
  }
  return continues(edge, part_) ? Refusal::None : Refusal::Seam;
}

bool Mesh::stretches_a_chart(Edge edge) const { return !continues(edge, sheet_); }

double Mesh::stretch(Edge edge, const Vec3& to) const {
  const WedgePairs pairs = pairs_along(edge);
  Few alone;
  for (const int f : faces_around(edge.removed)) {
    const int sheet = sheet_[faces_[f].wedge_at(edge.removed)];
    const auto is_it = [&](const WedgePair& p) { return sheet_[p.removed] == sheet; };
    if (std::ranges::none_of(pairs, is_it)) insert(alone, sheet);
  }
  double area = 0;
  for (const int sheet : alone) area += texture_.area(sheet);
  return area * (to - position[edge.removed]).squaredNorm();
}

// Gives the wedges at both ends the attributes of the point at `t` between them. Sheets blend as a whole, or
// they would crack in texture space; normals and colours blend only where the two wedges shade the same face.
void Mesh::blend_wedges(Edge edge, double t, const WedgePairs& pairs) {
  const AttributeLayout& layout = source_.layout;
  Rows& attributes = source_.attributes;
  const int uv = layout.uv_at(0), uv_size = 2 * layout.uv_sets;

  std::vector<int> wedges;
  for (const int v : {edge.kept, edge.removed}) {
    for (const int f : faces_around(v)) wedges.push_back(faces_[f].wedge_at(v));
  }
  sort_unique(wedges);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const int removed = sheet_[pairs[i].removed], kept = sheet_[pairs[i].kept];
    const auto same = [&](const WedgePair& p) { return sheet_[p.kept] == kept; };
    if (std::find_if(pairs.begin(), pairs.end(), same) != pairs.begin() + std::ptrdiff_t(i)) continue;
    const Eigen::RowVectorXd blended = (1 - t) * attributes.row(pairs[i].kept).segment(uv, uv_size) +
                                       t * attributes.row(pairs[i].removed).segment(uv, uv_size);
    for (const int w : wedges) {
      if (sheet_[w] == kept || sheet_[w] == removed) attributes.row(w).segment(uv, uv_size) = blended;
    }
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
      source_.normal_morphs[kept] = blend(source_.normal_morphs[kept], source_.normal_morphs[removed], t);
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
  if (stretches_a_chart(edge)) edge = edge.turned();
  const WedgePairs pairs = pairs_along(edge);
  Few kept_wedges, removed_wedges, kept_sheets, removed_sheets;
  for (const int f : faces_around(edge.kept)) {
    const int wedge = faces_[f].wedge_at(edge.kept);
    insert(kept_wedges, wedge), insert(kept_sheets, sheet_[wedge]);
  }
  for (const int f : faces_around(edge.removed)) {
    const int wedge = faces_[f].wedge_at(edge.removed);
    insert(removed_wedges, wedge), insert(removed_sheets, sheet_[wedge]);
  }
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

bool Mesh::turns_a_uv(Edge edge, const Vec3& to) const {
  const AttributeLayout& layout = source_.layout;
  if (layout.uv_sets == 0) return false;
  const WedgePairs pairs = pairs_along(edge);
  const double t = way_along(edge, to);
  const auto before = [&](int wedge, int at) -> Vec2 {
    return source_.attributes.row(wedge).segment<2>(at).transpose();
  };
  const auto after = [&](int wedge, int at) -> Vec2 {
    for (const auto& [removed, kept] : pairs) {
      if (sheet_[wedge] == sheet_[kept] || sheet_[wedge] == sheet_[removed])
        return (1 - t) * before(kept, at) + t * before(removed, at);
    }
    return before(wedge, at);
  };
  for (const int end : {edge.kept, edge.removed}) {
    for (const int f : faces_around(end)) {
      const Face& its = faces_[f];
      if (contains(face(f), end == edge.kept ? edge.removed : edge.kept)) continue;
      const int n = its.corners;
      int i = 0;
      while (its.vertex[i] != end) ++i;
      for (int set = 0; set < layout.uv_sets; ++set) {
        const int at = layout.uv_at(set);
        const Vec2 a = before(its.wedge[(i + 1) % n], at), b = before(its.wedge[(i + n - 1) % n], at);
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
  const auto end = pool_.begin() + run.begin + run.count--;
  const auto at = std::find(end - run.count - 1, end, face);
  std::copy(at + 1, end, at);
}

void Mesh::collapse(Edge edge, const Vec3& to, const std::optional<MorphOffsets>& morphs) {
  const int kept = edge.kept, removed = edge.removed;
  const WedgePairs pairs = pairs_along(edge);
  const double t = way_along(edge, to);
  blend_wedges(edge, t, pairs);
  for (const auto& [gone, stays] : pairs_of_wedges(pairs)) shading_.merge(stays, gone);
  for (const auto& [gone, stays] : pairs_of_sheets(pairs)) texture_.merge(stays, gone);
  if (!source_.morphs.empty()) {
    if (kind_[kept] != Kind::Locked)
      source_.morphs[kept] = morphs ? *morphs : blend(source_.morphs[kept], source_.morphs[removed], t);
    source_.morphs[removed].clear();
  }

  Few moved;  // to the kept end, ascending
  for (const int f : faces_around(removed)) {
    Face& face = faces_[f];
    const int at = int(std::find(face.vertex.begin(), face.vertex.end(), removed) - face.vertex.begin());
    const int wedge = face.wedge[at];
    if (!contains(this->face(f), kept)) {
      // A wedge that shades one face with a wedge of the kept end goes over into it; others move along.
      const auto partner =
          std::find_if(pairs.begin(), pairs.end(), [&](const WedgePair& p) { return p.removed == wedge; });
      if (partner != pairs.end()) {
        face.wedge[at] = partner->kept;
      } else {
        const auto sheet = std::find_if(pairs.begin(), pairs.end(), [&](const WedgePair& p) {
          return sheet_[p.removed] == sheet_[wedge];
        });
        if (sheet != pairs.end()) sheet_[wedge] = sheet_[sheet->kept];
        source_.wedges[wedge].vertex = kept;
      }
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
      std::copy(face.vertex.begin() + at + 1, face.vertex.end(), face.vertex.begin() + at);
      std::copy(face.wedge.begin() + at + 1, face.wedge.end(), face.wedge.begin() + at);
      face.corners = 3;
    }
  }
  const auto own = faces_around(kept);
  Few faces;
  std::merge(own.begin(), own.end(), moved.begin(), moved.end(), std::back_inserter(faces));
  around_[kept] = {int(pool_.size()), int(faces.size())};
  around_[removed].count = 0;
  pool_.insert(pool_.end(), faces.begin(), faces.end());
  position[kept] = to;
  kind_[kept] = std::max(kind_[kept], kind_[removed]);
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
