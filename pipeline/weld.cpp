// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/error.h"
#include "pipeline/findings.h"
#include "pipeline/repair.h"
#include "pipeline/side_by_side.h"

namespace skinlod {
namespace {

constexpr double kWeightTolerance = 1e-4;
constexpr double kMorphTolerance = 1e-7;  // of the diagonal

// At one place no real file has more different vertices than this; a forged one must not cost quadratic time.
constexpr size_t kMostCompared = 64;

// Where a point is, to the 24 bits that a float has for its largest coordinate: the binary exponent of that
// coordinate, and a cell.
using Place = std::array<std::int64_t, 4>;

// Values that people model lie on round numbers, and there rounding would part two points that differ in a
// last bit. So exponents change at 1/1.1 of a power of two and cells begin at an odd fraction.
Place place_of(const Vec3& x, double diagonal) {
  const double size = std::max(x.cwiseAbs().maxCoeff(), 1e-4 * diagonal);
  int exponent = 0;
  std::frexp(1.1 * size, &exponent);
  const auto cell = [&](double t) { return std::int64_t(std::floor(std::ldexp(t, 25 - exponent) + 0.382)); };
  return {exponent, cell(x.x()), cell(x.y()), cell(x.z())};
}

std::strong_ordering in_order(double a, double b) {
  return a < b   ? std::strong_ordering::less
         : a > b ? std::strong_ordering::greater
                 : std::strong_ordering::equal;
}

std::strong_ordering in_order(const Influence& a, const Influence& b) {
  return a.joint != b.joint ? a.joint <=> b.joint : in_order(a.weight, b.weight);
}

std::strong_ordering in_order(const MorphOffset& a, const MorphOffset& b) {
  if (a.morph != b.morph) return a.morph <=> b.morph;
  for (int i = 0; i < 3; ++i) {
    if (const auto order = in_order(a.delta[i], b.delta[i]); order != 0) return order;
  }
  return std::strong_ordering::equal;
}

std::strong_ordering in_sequence(const auto& a, const auto& b) {
  return std::lexicographical_compare_three_way(a.begin(), a.end(), b.begin(), b.end(),
                                                [](const auto& x, const auto& y) { return in_order(x, y); });
}

// True where no item of two lists that ascend by `key` is farther than `tolerance` from that of the other;
// what a list leaves out counts as 0.
bool nearly_equal(const auto& a, const auto& b, const auto& key, const auto& distance, double tolerance) {
  bool near = true;
  side_by_side(a, b, key, [&](auto* i, auto* j) { near = near && !(distance(i, j) > tolerance); });
  return near;
}

bool nearly_equal(const Influences& a, const Influences& b) {
  return nearly_equal(
      a, b, [](const Influence& i) { return i.joint; },
      [](const Influence* i, const Influence* j) {
        return std::abs((i ? i->weight : 0) - (j ? j->weight : 0));
      },
      kWeightTolerance);
}

bool nearly_equal(const MorphOffsets& a, const MorphOffsets& b, double diagonal) {
  return nearly_equal(
      a, b, [](const MorphOffset& o) { return o.morph; },
      [](const MorphOffset* o, const MorphOffset* p) {
        return ((o ? o->delta : Vec3::Zero()) - (p ? p->delta : Vec3::Zero())).norm();
      },
      kMorphTolerance * diagonal);
}

// Which items become one: each item's leader, the first of its class; -1 for items that nobody uses.
using Leaders = std::vector<int>;

// The classes of the used items that `order` finds equal.
Leaders leaders_of_equals(const std::vector<bool>& used, const auto& order) {
  std::vector<int> items;
  for (int i = 0; i < int(used.size()); ++i) {
    if (used[i]) items.push_back(i);
  }
  std::sort(items.begin(), items.end(), [&](int a, int b) {
    const std::strong_ordering its = order(a, b);
    return its != 0 ? its < 0 : a < b;
  });
  Leaders leader(used.size(), -1);
  for (size_t i = 0; i < items.size(); ++i) {
    const bool joins = i > 0 && order(items[i - 1], items[i]) == 0;
    leader[items[i]] = joins ? leader[items[i - 1]] : items[i];
  }
  return leader;
}

// Numbers the leaders in their order and says by which number each item goes; -1 for unused items.
std::vector<int> numbers(const Leaders& leader) {
  std::vector<int> number(leader.size(), -1);
  int next = 0;
  for (size_t i = 0; i < leader.size(); ++i) {
    if (leader[i] >= 0) number[i] = leader[i] == int(i) ? next++ : number[leader[i]];
  }
  return number;
}

// Lists of numbers, one after another.
class Lists {
 public:
  void add(std::span<const int> list) {
    all_.insert(all_.end(), list.begin(), list.end());
    end_.push_back(all_.size());
  }
  size_t size() const { return end_.size(); }
  std::span<const int> operator[](int i) const {
    const size_t begin = i == 0 ? 0 : end_[size_t(i) - 1];
    return std::span(all_).subspan(begin, end_[size_t(i)] - begin);
  }

 private:
  std::vector<int> all_;
  std::vector<size_t> end_;
};

class Welding {
 public:
  explicit Welding(Character& character)
      : character_(character), old_(character.surface), findings_(character.parts) {}

  Warnings weld() {
    const std::vector<int> vertex = numbers(join_vertices());
    new_.layout = old_.layout;
    for (size_t v = 0; v < vertex.size(); ++v) {
      if (vertex[v] != int(new_.position.size())) continue;
      new_.position.push_back(old_.position[v]);
      new_.influences.push_back(std::move(old_.influences[v]));
      if (!old_.morphs.empty()) new_.morphs.push_back(std::move(old_.morphs[v]));
    }
    const std::vector<int> wedge = numbers(join_wedges(vertex));
    std::vector<int> source;  // of each new wedge
    for (size_t w = 0; w < wedge.size(); ++w) {
      if (wedge[w] != int(source.size())) continue;
      source.push_back(int(w));
      new_.wedges.push_back({vertex[old_.wedges[w].vertex], old_.wedges[w].part});
      if (!old_.normal_morphs.empty()) new_.normal_morphs.push_back(std::move(old_.normal_morphs[w]));
    }
    new_.attributes.resize(Eigen::Index(source.size()), old_.attributes.cols());
    for (size_t w = 0; w < source.size(); ++w) {
      new_.attributes.row(Eigen::Index(w)) = old_.attributes.row(source[w]);
    }
    add_faces(wedge);
    note_non_manifold_edges();
    character_.surface = std::move(new_);
    return findings_.warnings();
  }

 private:
  Leaders join_vertices() {
    std::vector<bool> used(old_.position.size(), false);
    std::vector<int> part(old_.position.size(), -1);
    for (const int w : old_.corners) {
      const auto& [v, its] = old_.wedges[w];
      used[v] = true;
      if (part[v] < 0) part[v] = its;
    }
    const double size = diagonal(old_.position);
    std::vector<Place> place;
    for (const Vec3& x : old_.position) place.push_back(place_of(x, size));
    static const MorphOffsets kNone;
    const auto morphs = [&](int v) -> const auto& { return old_.morphs.empty() ? kNone : old_.morphs[v]; };
    Leaders leader = leaders_of_equals(used, [&](int a, int b) {
      if (const auto order = place[a] <=> place[b]; order != 0) return order;
      if (const auto order = in_sequence(morphs(a), morphs(b)); order != 0) return order;
      return in_sequence(old_.influences[a], old_.influences[b]);
    });

    // What is left at each place, in the order of the file: joined where only rounding keeps it apart.
    std::vector<int> left;
    for (int v = 0; v < int(leader.size()); ++v) {
      if (leader[v] == v) left.push_back(v);
    }
    std::stable_sort(left.begin(), left.end(), [&](int a, int b) { return place[a] < place[b]; });
    std::vector<int> kept;  // at the current place
    for (size_t i = 0; i < left.size(); ++i) {
      const int v = left[i];
      if (i == 0 || place[left[i - 1]] != place[v]) kept.clear();
      const auto end = kept.begin() + std::ptrdiff_t(std::min(kept.size(), kMostCompared));
      const auto like = std::find_if(kept.begin(), end, [&](int k) {
        return nearly_equal(old_.influences[k], old_.influences[v]) &&
               nearly_equal(morphs(k), morphs(v), size);
      });
      if (like != end) {
        leader[v] = *like;
        if (old_.influences[*like] != old_.influences[v]) {
          findings_.note(WarningCode::WeightsNearlyEqual, part[v], "joined; the first one's weights kept");
        }
      } else {
        if (!kept.empty()) findings_.note(WarningCode::PartsCoincide, part[v], "kept apart");
        kept.push_back(v);
      }
    }
    // A leader may have found a leader of its own; it stands before all who follow it.
    for (int& l : leader) {
      if (l >= 0) l = leader[l];
    }
    return leader;
  }

  Leaders join_wedges(const std::vector<int>& vertex) const {
    std::vector<bool> used(old_.wedges.size(), false);
    for (const int w : old_.corners) used[w] = true;
    return leaders_of_equals(used, [&](int a, int b) {
      const Wedge &first = old_.wedges[a], &second = old_.wedges[b];
      if (vertex[first.vertex] != vertex[second.vertex])
        return vertex[first.vertex] <=> vertex[second.vertex];
      if (first.part != second.part) return first.part <=> second.part;
      for (Eigen::Index i = 0; i < old_.attributes.cols(); ++i) {
        const auto order = in_order(old_.attributes(a, i), old_.attributes(b, i));
        if (order != 0) return order;
      }
      if (old_.normal_morphs.empty()) return std::strong_ordering::equal;
      return in_sequence(old_.normal_morphs[a], old_.normal_morphs[b]);
    });
  }

  void add_faces(const std::vector<int>& wedge) {
    Lists faces, turns;  // a turn is a part, and a face's vertices from the lowest on: up to where it starts
    std::vector<int> face, turn, sorted;
    for (int f = 0; f < old_.face_count(); ++f) {
      face.clear();
      for (const int w : old_.face(f)) face.push_back(wedge[w]);
      const int part = old_.part(f);
      const auto same_vertex = [&](int a, int b) { return new_.wedges[a].vertex == new_.wedges[b].vertex; };
      face.erase(std::unique(face.begin(), face.end(), same_vertex), face.end());
      while (face.size() > 1 && same_vertex(face.front(), face.back())) face.pop_back();
      turn.assign(1, part);
      for (const int w : face) turn.push_back(new_.wedges[w].vertex);
      std::rotate(turn.begin() + 1, std::min_element(turn.begin() + 1, turn.end()), turn.end());
      sorted.assign(turn.begin() + 1, turn.end());
      std::sort(sorted.begin(), sorted.end());
      if (face.size() < 3 || std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) {
        findings_.note(WarningCode::FaceDegenerate, part, "two equal corners, removed");
        continue;
      }
      if (face.size() < old_.face(f).size())
        findings_.note(WarningCode::FaceDegenerate, part, "doubled corner removed");
      faces.add(face), turns.add(turn);
    }
    const Leaders leader = leaders_of_equals(std::vector<bool>(faces.size(), true), [&](int a, int b) {
      const auto first = turns[a], second = turns[b];
      return std::lexicographical_compare_three_way(first.begin(), first.end(), second.begin(), second.end());
    });
    for (int f = 0; f < int(faces.size()); ++f) {
      if (leader[f] == f) {
        new_.add_face(faces[f]);
      } else {
        findings_.note(WarningCode::FaceDuplicate, turns[f][0], "removed");
      }
    }
    if (new_.face_count() == 0) {
      throw Error{Fault::Input, character_.name +
                                    ": no face is left after welding: export it with a mesh "
                                    "whose corners do not coincide"};
    }
  }

  void note_non_manifold_edges() {
    struct Side {
      int low, high, face;
      auto operator<=>(const Side&) const = default;
    };
    std::vector<Side> sides;
    for (int f = 0; f < new_.face_count(); ++f) {
      const auto face = new_.face(f);
      for (size_t i = 0; i < face.size(); ++i) {
        const int a = new_.wedges[face[i]].vertex, b = new_.wedges[face[(i + 1) % face.size()]].vertex;
        sides.push_back({std::min(a, b), std::max(a, b), f});
      }
    }
    std::sort(sides.begin(), sides.end());
    for (size_t begin = 0, end; begin < sides.size(); begin = end) {
      for (end = begin; end < sides.size() && sides[end].low == sides[begin].low &&
                        sides[end].high == sides[begin].high;) {
        ++end;
      }
      if (end - begin > 2)
        findings_.note(WarningCode::NonManifoldEdges, new_.part(sides[begin].face), "kept");
    }
  }

  Character& character_;
  Surface& old_;
  Surface new_;
  Findings findings_;
};

}  // namespace

void merge_materials(Character& character) {
  const std::vector<Part>& parts = character.parts;
  std::vector<int> drawn_as;
  for (const Part& part : parts) {
    const auto first = std::find_if(parts.begin(), parts.end(), [&](const Part& p) {
      return p.node == part.node && p.material == part.material && p.has == part.has;
    });
    drawn_as.push_back(int(first - parts.begin()));
  }
  for (Wedge& wedge : character.surface.wedges) wedge.part = drawn_as[wedge.part];
}

Warnings weld(Character& character) { return Welding(character).weld(); }

Surface without_attributes(const Surface& surface) {
  Character bare;
  bare.name = "surface";
  bare.parts = {{.name = "all"}};
  Surface& s = bare.surface;
  s.position = surface.position;
  s.influences = surface.influences;
  for (int v = 0; v < int(s.position.size()); ++v) s.wedges.push_back({v, 0});
  s.attributes.resize(Eigen::Index(s.wedges.size()), 0);
  for (const int wedge : surface.corners) s.corners.push_back(surface.wedges[wedge].vertex);
  s.face_begin = surface.face_begin;
  weld(bare);
  return std::move(bare.surface);
}

}  // namespace skinlod
