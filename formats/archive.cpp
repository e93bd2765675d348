// SPDX-License-Identifier: MIT
#include "formats/archive.h"

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
  template <class T>
  void shape(T& items) {
    const std::uint64_t size = items.size();
    raw(&size, sizeof size);
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

/// Refuses sizes that the bytes left cannot fill, so that a lie about one allocates nothing.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}

  void raw(void* data, size_t size) {
    require(size <= left_.size());
    if (size > 0) std::memcpy(data, left_.data(), size);
    left_ = left_.subspan(size);
  }
  template <class T>
  void shape(T& items) {
    std::uint64_t size = 0;
    raw(&size, sizeof size);
    require(size <= left_.size());
    items.resize(size);
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
  a.shape(text);
  a.raw(text.data(), text.size());
}

template <class A, class T>
void visit(A& a, std::optional<T>& value) {
  a.shape(value);
  if (value) visit(a, *value);
}

template <class A, class T>
void visit(A& a, std::vector<T>& items) {
  a.shape(items);
  for (T& item : items) visit(a, item);
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
  reader.require(reader.at_end());
  return imported;
}

}  // namespace skinlod
