// SPDX-License-Identifier: MIT
#include "formats/gltf_accessor.h"

#include <algorithm>
#include <cstring>

namespace skinlod {
namespace {

constexpr size_t kMostElements = size_t(1) << 26;
constexpr size_t kMostZeroBytes = size_t(1) << 24;

size_t component_size(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;  // int and double are constants of OpenGL, not of glTF
  }
}

// The columns of small matrices start at multiples of four bytes.
size_t element_size(int type, int component_type) {
  const size_t size = component_size(component_type);
  if (type == TINYGLTF_TYPE_MAT2) return 2 * ((2 * size + 3) / 4 * 4);
  if (type == TINYGLTF_TYPE_MAT3) return 3 * ((3 * size + 3) / 4 * 4);
  return size * size_t(component_count(type));
}

// `count` elements of `size` bytes, `stride` apart from `offset` on, one after the other.
std::vector<unsigned char> gather(const GltfDocument& doc, const std::string& part,
                                  std::span<const unsigned char> view, size_t offset, size_t stride,
                                  size_t count, size_t size) {
  // Nothing overflows: count is at most 2^26, stride at most 252. Nothing is allocated that is not there.
  const size_t length = count == 0 ? 0 : (count - 1) * stride + size;
  if (offset > view.size() || length > view.size() - offset) {
    const size_t past = std::min(offset, size_t(1) << 62) + length - view.size();
    doc.fail(part, "runs " + std::to_string(past) + " bytes past its buffer view");
  }
  std::vector<unsigned char> out(count * size);
  for (size_t i = 0; i < count; ++i) std::memcpy(&out[i * size], &view[offset + i * stride], size);
  return out;
}

template <class T>
T load(const unsigned char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

std::uint32_t load_unsigned(const unsigned char* at, int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return *at;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load<std::uint16_t>(at);
    default:
      return load<std::uint32_t>(at);
  }
}

double load_number(const unsigned char* at, int component_type, bool normalised) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
      const double c = load<std::int8_t>(at);
      return normalised ? std::max(c / 127, -1.0) : c;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return normalised ? *at / 255.0 : *at;
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
      const double c = load<std::int16_t>(at);
      return normalised ? std::max(c / 32767, -1.0) : c;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
      const double c = load<std::uint16_t>(at);
      return normalised ? c / 65535 : c;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return load<std::uint32_t>(at);
    default:
      return double(load<float>(at));
  }
}

void put_sparse(const GltfDocument& doc, const tinygltf::Accessor& accessor, Elements& elements) {
  const auto& sparse = accessor.sparse;
  const std::string part = elements.part + ": sparse";
  const int index_type = sparse.indices.componentType;
  if (size_t(sparse.count) > elements.count) {
    doc.fail(part, "replaces " + std::to_string(sparse.count) + " of " + std::to_string(elements.count) +
                       " elements");
  }
  if (index_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
      index_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      index_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) {
    doc.fail(part, "its indices have component type " + std::to_string(index_type));
  }
  const size_t count = size_t(sparse.count), index_size = component_size(index_type);
  const auto indices = gather(doc, part + " indices", view_bytes(doc, part, sparse.indices.bufferView),
                              size_t(sparse.indices.byteOffset), index_size, count, index_size);
  const auto values = gather(doc, part + " values", view_bytes(doc, part, sparse.values.bufferView),
                             size_t(sparse.values.byteOffset), elements.size, count, elements.size);
  std::int64_t last = -1;
  for (size_t i = 0; i < count; ++i) {
    const std::int64_t at = load_unsigned(&indices[i * index_size], index_type);
    if (at <= last || size_t(at) >= elements.count) {
      doc.fail(part,
               "its index " + std::to_string(at) + (at <= last ? " does not ascend" : " is out of range"));
    }
    last = at;
    std::memcpy(&elements.bytes[size_t(at) * elements.size], &values[i * elements.size], elements.size);
  }
}

bool is_legal(Legal legal, int component_type, bool normalised) {
  const bool is_float = component_type == TINYGLTF_COMPONENT_TYPE_FLOAT;
  const bool is_int = component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  const bool is_signed =
      component_type == TINYGLTF_COMPONENT_TYPE_BYTE || component_type == TINYGLTF_COMPONENT_TYPE_SHORT;
  const bool is_small = !is_float && !is_int;
  if (normalised && !is_small) return false;
  switch (legal) {
    case Legal::Position:
    case Legal::Coordinate:
      return is_float || is_small;
    case Legal::Direction:
      return is_float || (is_signed && normalised);
    case Legal::Colour:
    case Legal::Weights:
      return is_float || (is_small && !is_signed && normalised);
    case Legal::Joints:
      return is_small && !is_signed && !normalised;
    case Legal::Indices:
      return !is_float && !is_signed && !normalised;
    case Legal::Matrix:
    case Legal::Float:
      return is_float;
    case Legal::Keys:
      return is_float || normalised;
  }
  return false;
}

Elements read_legal(const GltfDocument& doc, int index, Legal legal, std::initializer_list<int> types) {
  Elements elements = read_elements(doc, index);
  if (std::find(types.begin(), types.end(), elements.type) == types.end() ||
      !is_legal(legal, elements.component_type, elements.normalised)) {
    doc.fail(elements.part, "its type is not allowed where it is used");
  }
  return elements;
}

}  // namespace

std::span<const unsigned char> image_bytes(const GltfDocument& doc, size_t image) {
  const Json& view = member(doc.json["images"][image], "bufferView");
  if (!view.is_null()) return view_bytes(doc, "image " + std::to_string(image), view.get<int>());
  if (!doc.images[image]) return {};
  return *doc.images[image];
}

std::span<const unsigned char> view_bytes(const GltfDocument& doc, const std::string& part, int index) {
  if (index < 0 || size_t(index) >= doc.model.bufferViews.size()) {
    doc.fail(part, "its buffer view " + std::to_string(index) + " does not exist");
  }
  const tinygltf::BufferView& view = doc.model.bufferViews[size_t(index)];
  if (view.buffer < 0 || size_t(view.buffer) >= doc.buffers.size()) {
    doc.fail("buffer view " + std::to_string(index),
             "its buffer " + std::to_string(view.buffer) + " does not exist");
  }
  static const std::vector<unsigned char> none;
  const SharedBytes& buffer = doc.buffers[size_t(view.buffer)];
  const std::vector<unsigned char>& data = buffer ? *buffer : none;
  if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset) {
    doc.fail("buffer view " + std::to_string(index), "runs past the " + std::to_string(data.size()) +
                                                         " bytes of buffer " + std::to_string(view.buffer));
  }
  return std::span(data).subspan(view.byteOffset, view.byteLength);
}

int component_count(int type) { return tinygltf::GetNumComponentsInType(std::uint32_t(type)); }

Elements read_elements(const GltfDocument& doc, int index) {
  Elements elements{.part = "accessor " + std::to_string(index), .bytes = {}};
  if (index < 0 || size_t(index) >= doc.model.accessors.size()) doc.fail(elements.part, "does not exist");
  const tinygltf::Accessor& accessor = doc.model.accessors[size_t(index)];
  elements.component_type = accessor.componentType;
  elements.type = accessor.type;
  elements.normalised = accessor.normalized;
  elements.count = accessor.count;
  elements.size = element_size(accessor.type, accessor.componentType);
  if (elements.size == 0)
    doc.fail(elements.part, "has component type " + std::to_string(accessor.componentType));
  if (elements.count == 0 || elements.count > kMostElements) {
    doc.fail(elements.part, "has " + std::to_string(elements.count) + " elements");
  }
  const size_t total = elements.count * elements.size;
  if (accessor.bufferView < 0) {
    if (total > kMostZeroBytes)
      doc.fail(elements.part, "stands for " + std::to_string(total) + " bytes and has none");
    elements.bytes.resize(total);
  } else {
    const std::span view = view_bytes(doc, elements.part, accessor.bufferView);
    const size_t given = doc.model.bufferViews[size_t(accessor.bufferView)].byteStride;
    const size_t stride = given == 0 ? elements.size : given;
    if (stride < elements.size) doc.fail(elements.part, "its elements overlap");
    elements.bytes =
        gather(doc, elements.part, view, accessor.byteOffset, stride, elements.count, elements.size);
  }
  if (accessor.sparse.isSparse) put_sparse(doc, accessor, elements);
  return elements;
}

Rows read_rows(const GltfDocument& doc, int index, Legal legal, std::initializer_list<int> types) {
  const Elements elements = read_legal(doc, index, legal, types);
  Rows rows(Eigen::Index(elements.count), component_count(elements.type));
  const size_t size = component_size(elements.component_type);
  for (Eigen::Index i = 0; i < rows.size(); ++i) {
    rows.data()[i] =
        load_number(&elements.bytes[size_t(i) * size], elements.component_type, elements.normalised);
  }
  return rows;
}

std::vector<std::uint32_t> read_integers(const GltfDocument& doc, int index, Legal legal, int type) {
  const Elements elements = read_legal(doc, index, legal, {type});
  const size_t size = component_size(elements.component_type);
  std::vector<std::uint32_t> integers(elements.bytes.size() / size);
  for (size_t i = 0; i < integers.size(); ++i) {
    integers[i] = load_unsigned(&elements.bytes[i * size], elements.component_type);
  }
  return integers;
}

}  // namespace skinlod
