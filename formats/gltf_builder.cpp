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
  const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> floats = rows.cast<float>();
  Json accessor = {{"componentType", kFloat}, {"count", rows.rows()}, {"type", type_name(rows.cols())}};
  if (rows.cols() == 1 || rows.cols() == 3) {
    for (Eigen::Index column = 0; column < rows.cols(); ++column) {
      accessor["min"].push_back(floats.col(column).minCoeff());
      accessor["max"].push_back(floats.col(column).maxCoeff());
    }
  }
  if (use == Use::Vertex && floats.isZero(0)) return add_elements(std::move(accessor), {}, 0, use);
  std::vector<unsigned char> bytes(size_t(floats.size()) * sizeof(float));
  std::memcpy(bytes.data(), floats.data(), bytes.size());
  return add_elements(std::move(accessor), bytes, size_t(rows.cols()) * sizeof(float), use);
}

int GltfBuilder::add_integers(std::span<const std::uint32_t> values, int components, int bytes, Use use) {
  std::vector<unsigned char> encoded;
  encoded.reserve(values.size() * size_t(bytes));
  for (const std::uint32_t value : values) {
    for (int shift = 0; shift < 8 * bytes; shift += 8)
      encoded.push_back((unsigned char)(value >> shift & 255));
  }
  const int type = bytes == 1 ? kByte : bytes == 2 ? kShort : kInt;
  Json accessor = {{"componentType", type},
                   {"count", values.size() / size_t(components)},
                   {"type", type_name(components)}};
  return add_elements(std::move(accessor), encoded, size_t(components * bytes), use);
}

int GltfBuilder::add_elements(Json accessor, std::span<const unsigned char> bytes, size_t size, Use use) {
  if (!bytes.empty()) {
    const size_t stride = use == Use::Vertex ? size : 0;
    const auto [place, fresh] = shared_.try_emplace({use, stride}, int(views_.size()));
    if (fresh) views_.push_back({use, stride});
    std::vector<unsigned char>& view = views_[size_t(place->second)].bytes;
    accessor["bufferView"] = place->second;
    accessor["byteOffset"] = view.size();
    view.insert(view.end(), bytes.begin(), bytes.end());
    pad(view, 0);
  }
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
