// SPDX-License-Identifier: MIT
#include "formats/archive.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <type_traits>

#include "pipeline/error.h"

// One `visit` per type says what belongs to it. Writer and Reader go over the same visits, so that they
// cannot disagree.
namespace skinlod {
namespace {

class Writer {
 public:
  std::vector<std::byte> bytes;

  void raw(const void* data, size_t size) {
    const auto* from = static_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), from, from + size);
  }
  void text(std::string& text) {
    const std::uint64_t size = text.size();
    raw(&size, sizeof size);
    raw(text.data(), text.size());
  }
  void list(auto& items, const auto& visit_item) {
    const std::uint64_t size = items.size();
    raw(&size, sizeof size);
    for (auto& item : items) visit_item(item);
  }
  void shape(Rows& table) {
    for (const std::int64_t size : {table.rows(), table.cols()}) raw(&size, sizeof size);
  }
  template <class T>
  void shape(std::optional<T>& value) {
    const unsigned char there = value.has_value();
    raw(&there, sizeof there);
  }
};

/// Allocates for nothing that it has not read: a lie about a size soon comes to the end of the bytes.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}

  void raw(void* data, size_t size) {
    require(size <= left_.size());
    if (size > 0) std::memcpy(data, left_.data(), size);
    left_ = left_.subspan(size);
  }
  void text(std::string& text) {
    std::uint64_t size = 0;
    raw(&size, sizeof size);
    require(size <= left_.size());
    text.resize(size);
    raw(text.data(), text.size());
  }
  void list(auto& items, const auto& visit_item) {
    std::uint64_t size = 0;
    raw(&size, sizeof size);
    items.clear();
    for (std::uint64_t i = 0; i < size; ++i) {
      require(!at_end());
      visit_item(items.emplace_back());
    }
  }
  void shape(Rows& table) {
    std::int64_t rows = 0, columns = 0;
    raw(&rows, sizeof rows), raw(&columns, sizeof columns);
    require(rows >= 0 && columns >= 0);
    require(columns == 0 || rows <= std::int64_t(left_.size() / sizeof(double)) / columns);
    table.resize(rows, columns);
  }
  template <class T>
  void shape(std::optional<T>& value) {
    unsigned char there = 0;
    raw(&there, sizeof there);
    if (there) value.emplace();
  }
  void require(bool holds) const {
    if (!holds) throw Error(Fault::Input, "the reader's answer is torn: run again");
  }
  bool at_end() const { return left_.empty(); }

 private:
  std::span<const std::byte> left_;
};

template <class A, class... T>
void visit_all(A& a, T&... members) {
  (visit(a, members), ...);
}

template <class A, class T>
requires std::is_arithmetic_v<T> || std::is_enum_v<T>
void visit(A& a, T& value) { a.raw(&value, sizeof value); }

template <class A>
void visit(A& a, bool& value) {
  unsigned char byte = value;  // no other bits may end up in a bool
  a.raw(&byte, sizeof byte);
  value = byte != 0;
}

template <class A, int R, int C>
void visit(A& a, Eigen::Matrix<double, R, C>& m) {
  a.raw(m.data(), size_t(m.size()) * sizeof(double));
}

template <class A>
void visit(A& a, Rows& table) {
  a.shape(table);
  a.raw(table.data(), size_t(table.size()) * sizeof(double));
}

template <class A>
void visit(A& a, std::string& text) {
  a.text(text);
}

template <class A, class T>
void visit(A& a, std::optional<T>& value) {
  a.shape(value);
  if (value) visit(a, *value);
}

template <class A, class T>
void visit(A& a, std::vector<T>& items) {
  a.list(items, [&](T& item) { visit(a, item); });
}
template <class A>
void visit(A& a, Influences& influences) {
  a.list(influences, [&](Influence& item) { visit(a, item); });
}

template <class A>
void visit(A& a, Transform& t) {
  visit_all(a, t.translation, t.rotation, t.scale);
}
template <class A>
void visit(A& a, Node& node) {
  visit_all(a, node.name, node.parent, node.rest, node.matrix);
}
template <class A>
void visit(A& a, Joint& joint) {
  visit_all(a, joint.node, joint.inverse_bind);
}
template <class A>
void visit(A& a, Channel& channel) {
  visit_all(a, channel.node, channel.path, channel.interpolation, channel.times, channel.values);
}
template <class A>
void visit(A& a, Clip& clip) {
  visit_all(a, clip.name, clip.channels);
}
template <class A>
void visit(A& a, Material& material) {
  visit_all(a, material.name, material.base_colour, material.texture, material.double_sided);
}
template <class A>
void visit(A& a, AttributeLayout& layout) {
  visit_all(a, layout.normal, layout.tangent, layout.uv_sets, layout.colour_sets);
}
template <class A>
void visit(A& a, Part& part) {
  visit_all(a, part.name, part.node, part.material, part.has);
}
template <class A>
void visit(A& a, Morph& morph) {
  visit_all(a, morph.name, morph.node, morph.weight);
}
template <class A>
void visit(A& a, Influence& influence) {
  visit_all(a, influence.joint, influence.weight);
}
template <class A>
void visit(A& a, MorphOffset& offset) {
  visit_all(a, offset.morph, offset.delta);
}
template <class A>
void visit(A& a, Wedge& wedge) {
  visit_all(a, wedge.vertex, wedge.part);
}
template <class A>
void visit(A& a, Surface& surface) {
  visit_all(a, surface.position, surface.influences, surface.morphs, surface.wedges, surface.layout,
            surface.attributes, surface.normal_morphs, surface.corners, surface.face_begin);
}
template <class A>
void visit(A& a, Character& character) {
  visit_all(a, character.name, character.skeleton.nodes, character.skeleton.joints, character.clips,
            character.materials, character.parts, character.morphs, character.surface);
}
template <class A>
void visit(A& a, Warning& warning) {
  visit_all(a, warning.code, warning.part, warning.count, warning.detail);
}
template <class A>
void visit(A& a, Imported& imported) {
  visit_all(a, imported.character, imported.warnings, imported.files_read);
}

bool is_index(int i, size_t count) { return i >= 0 && size_t(i) < count; }
bool is_index_or_none(int i, size_t count) { return i == -1 || is_index(i, count); }

bool all(const auto& items, const auto& holds) { return std::all_of(items.begin(), items.end(), holds); }

/// Whether the tables of a surface have rows and columns for each other. What its corners and influences name
/// is for `repair` to look at.
bool fits(const Surface& s, const std::vector<Part>& parts) {
  const auto no_more_than = [](const AttributeLayout& has, int uv_sets, int colour_sets) {
    return has.uv_sets >= 0 && has.uv_sets <= uv_sets && has.colour_sets >= 0 &&
           has.colour_sets <= colour_sets;
  };
  const bool has_columns = no_more_than(s.layout, 255, 255) && s.attributes.cols() == s.layout.columns() &&
                           all(parts, [&](const Part& part) {
                             return no_more_than(part.has, s.layout.uv_sets, s.layout.colour_sets) &&
                                    part.has.normal <= s.layout.normal &&
                                    part.has.tangent <= s.layout.tangent;
                           });
  const bool has_rows = s.influences.size() == s.position.size() &&
                        (s.morphs.empty() || s.morphs.size() == s.position.size()) &&
                        (s.normal_morphs.empty() || s.normal_morphs.size() == s.wedges.size()) &&
                        size_t(s.attributes.rows()) == s.wedges.size();
  const bool has_faces = !s.face_begin.empty() && s.face_begin.front() == 0 &&
                         size_t(s.face_begin.back()) == s.corners.size() &&
                         std::is_sorted(s.face_begin.begin(), s.face_begin.end());
  return (s.wedges.empty() || has_columns) && has_rows && has_faces;
}

bool fits(const Channel& channel, size_t nodes) {
  return is_index(channel.node, nodes) && channel.path <= Path::MorphWeights &&
         channel.interpolation <= Interpolation::CubicSpline;
}

/// Whether it is an answer that `read_scene` can give: what a broken file did to Assimp's heap may have
/// reached ours.
bool fits(const Imported& imported) {
  const Character& c = imported.character;
  const size_t nodes = c.skeleton.nodes.size(), materials = c.materials.size();
  return fits(c.surface, c.parts) &&
         all(c.skeleton.nodes, [&](const Node& n) { return is_index_or_none(n.parent, nodes); }) &&
         all(c.skeleton.joints, [&](const Joint& j) { return is_index(j.node, nodes); }) &&
         all(c.parts,
             [&](const Part& p) {
               return is_index(p.node, nodes) && is_index_or_none(p.material, materials);
             }) &&
         all(c.morphs, [&](const Morph& m) { return is_index(m.node, nodes); }) &&
         all(c.clips, [&](const Clip& clip) {
           return all(clip.channels, [&](const Channel& channel) { return fits(channel, nodes); });
         });
}

}  // namespace

std::vector<std::byte> to_bytes(const Imported& imported) {
  Writer writer;
  visit(writer, const_cast<Imported&>(imported));  // a Writer changes nothing
  return std::move(writer.bytes);
}

Imported from_bytes(std::span<const std::byte> bytes) {
  Reader reader(bytes);
  Imported imported;
  visit(reader, imported);
  reader.require(reader.at_end() && fits(imported));
  return imported;
}

}  // namespace skinlod
