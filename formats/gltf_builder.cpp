// SPDX-License-Identifier: MIT
#include "formats/gltf_builder.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>

#include "pipeline/error.h"

namespace skinlod {
namespace {

constexpr int kByte = 5121, kShort = 5123, kInt = 5125, kFloat = 5126;  // componentType

const char* type_name(Eigen::Index components) {
  switch (components) {
    case 1:
      return "SCALAR";
    case 2:
      return "VEC2";
    case 3:
      return "VEC3";
    case 4:
      return "VEC4";
    default:
      return "MAT4";
  }
}

using Floats = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::vector<unsigned char> encoded(const Floats& floats) {
  std::vector<unsigned char> bytes(size_t(floats.size()) * sizeof(float));
  std::memcpy(bytes.data(), floats.data(), bytes.size());
  return bytes;
}

std::vector<unsigned char> encoded(std::span<const std::uint32_t> values, int bytes) {
  std::vector<unsigned char> out;
  out.reserve(values.size() * size_t(bytes));
  for (const std::uint32_t value : values) {
    for (int shift = 0; shift < 8 * bytes; shift += 8) out.push_back((unsigned char)(value >> shift & 255));
  }
  return out;
}

// With the bounds that positions and times must have.
Json float_accessor(const Floats& floats) {
  Json accessor = {{"componentType", kFloat}, {"count", floats.rows()}, {"type", type_name(floats.cols())}};
  if (floats.cols() == 1 || floats.cols() == 3) {
    for (Eigen::Index column = 0; column < floats.cols(); ++column) {
      accessor["min"].push_back(floats.col(column).minCoeff());
      accessor["max"].push_back(floats.col(column).maxCoeff());
    }
  }
  return accessor;
}

template <class Bytes>
void pad(Bytes& bytes, unsigned char with) {
  while (bytes.size() % 4 != 0) bytes.push_back(typename Bytes::value_type(with));
}

void put(std::vector<std::byte>& out, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(std::byte(value >> shift & 255));
}

template <class Chars>
void put_chunk(std::vector<std::byte>& out, std::uint32_t kind, const Chars& chars) {
  put(out, std::uint32_t(chars.size())), put(out, kind);
  const auto* bytes = reinterpret_cast<const std::byte*>(chars.data());
  out.insert(out.end(), bytes, bytes + chars.size());
}

}  // namespace

int GltfBuilder::add_floats(const Rows& rows, Use use) {
  const Floats floats = rows.cast<float>();
  if (use == Use::Vertex && floats.isZero(0)) return add_elements(float_accessor(floats), {}, 0, use);
  return add_elements(float_accessor(floats), encoded(floats), size_t(rows.cols()) * sizeof(float), use);
}

int GltfBuilder::add_sparse(const Rows& rows) {
  constexpr size_t kText = 160;  // of the JSON that a sparse accessor has beside that of a plain one
  const Floats floats = rows.cast<float>();
  std::vector<std::uint32_t> places;
  for (Eigen::Index i = 0; i < floats.rows(); ++i) {
    if (!floats.row(i).isZero(0)) places.push_back(std::uint32_t(i));
  }
  const int type = floats.rows() <= 65535 ? kShort : kInt, bytes = type == kShort ? 2 : 4;
  const size_t row = size_t(floats.cols()) * sizeof(float);
  const size_t plain = size_t(floats.rows()) * row;
  if (places.empty() || places.size() * (row + size_t(bytes)) + kText >= plain)
    return add_floats(rows, Use::Vertex);
  Json accessor = float_accessor(floats);
  Json& sparse = accessor["sparse"];
  sparse["count"] = places.size();
  sparse["indices"] = stored(encoded(places, bytes), 0, Use::Sparse);
  sparse["indices"]["componentType"] = type;
  sparse["values"] = stored(encoded(floats(places, Eigen::all)), 0, Use::Sparse);
  return add_elements(std::move(accessor), {}, 0, Use::Vertex);
}

int GltfBuilder::add_integers(std::span<const std::uint32_t> values, int components, int bytes, Use use) {
  const int type = bytes == 1 ? kByte : bytes == 2 ? kShort : kInt;
  Json accessor = {{"componentType", type},
                   {"count", values.size() / size_t(components)},
                   {"type", type_name(components)}};
  return add_elements(std::move(accessor), encoded(values, bytes), size_t(components * bytes), use);
}

Json GltfBuilder::stored(std::span<const unsigned char> bytes, size_t size, Use use) {
  const size_t stride = use == Use::Vertex ? size : 0;
  const auto [place, fresh] = shared_.try_emplace({use, stride}, int(views_.size()));
  if (fresh) views_.push_back({use, stride});
  std::vector<unsigned char>& view = views_[size_t(place->second)].bytes;
  Json where = {{"bufferView", place->second}, {"byteOffset", view.size()}};
  view.insert(view.end(), bytes.begin(), bytes.end());
  pad(view, 0);
  return where;
}

int GltfBuilder::add_elements(Json accessor, std::span<const unsigned char> bytes, size_t size, Use use) {
  if (!bytes.empty()) accessor.update(stored(bytes, size, use));
  accessors_.push_back(std::move(accessor));
  return int(accessors_.size()) - 1;
}

int GltfBuilder::add_view(std::span<const unsigned char> bytes) {
  views_.push_back({Use::Plain, 0, {bytes.begin(), bytes.end()}});
  return int(views_.size()) - 1;
}

std::vector<std::byte> GltfBuilder::finish() {
  Json views = Json::array();
  std::vector<unsigned char> binary;
  for (const View& view : views_) {
    Json& entry = views.emplace_back(
        Json{{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", view.bytes.size()}});
    if (view.use == Use::Vertex) entry["target"] = 34962;
    if (view.use == Use::Index) entry["target"] = 34963;
    if (view.stride > 0) entry["byteStride"] = view.stride;
    binary.insert(binary.end(), view.bytes.begin(), view.bytes.end());
    pad(binary, 0);
  }
  if (!accessors_.empty()) json["accessors"] = accessors_;
  if (!views.empty()) json["bufferViews"] = views;
  if (!binary.empty()) json["buffers"] = Json::array({{{"byteLength", binary.size()}}});
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);  // names of other formats
  pad(text, ' ');

  const size_t length = 12 + 8 + text.size() + (binary.empty() ? 0 : 8 + binary.size());
  if (length > std::numeric_limits<std::uint32_t>::max()) {
    throw Error{Fault::Input, "a level has more than the 4 GB a GLB can hold: give smaller textures"};
  }
  std::vector<std::byte> file;
  file.reserve(length);
  put(file, 0x46546C67), put(file, 2), put(file, std::uint32_t(length));
  put_chunk(file, 0x4E4F534A, text);
  if (!binary.empty()) put_chunk(file, 0x004E4942, binary);
  return file;
}

}  // namespace skinlod
