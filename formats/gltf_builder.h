// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>
#include <vector>

#include "pipeline/linalg.h"

namespace skinlod {

using Json = nlohmann::json;

/// What an accessor is read as. The specification wants a buffer view for each.
enum class Use { Plain, Bind, Vertex, Index, Sparse };

/// Puts a GLB together: accessors over few, aligned buffer views of one buffer. The rest of the document is
/// in `json`, for all to edit.
class GltfBuilder {
 public:
  Json json = Json::object();

  /// Adds the table as floats, a row per element: 1 to 4 columns, or 16 for a matrix, whose rows are then the
  /// columns that glTF stores. With the bounds that positions and times must have.
  int add_floats(const Rows& rows, Use use);

  /// Adds a table for vertices, most of whose rows may be 0: as a sparse accessor where that is smaller.
  int add_sparse(const Rows& rows);

  /// Adds unsigned integers, `components` an element, in `bytes` bytes each: 1, 2 or 4.
  int add_integers(std::span<const std::uint32_t> values, int components, int bytes, Use use);

  /// Adds elements that are encoded already, `size` bytes each; `accessor` says how.
  int add_elements(Json accessor, std::span<const unsigned char> bytes, size_t size, Use use);

  /// Adds a buffer view of its own.
  int add_view(std::span<const unsigned char> bytes);

  /// The file. No accessor, buffer view or buffer is in it that was not added.
  std::vector<std::byte> finish();

 private:
  // Appends to the view that is shared by all of one use and stride; where it went, as JSON has it.
  Json stored(std::span<const unsigned char> bytes, size_t size, Use use);

  struct View {
    Use use;
    size_t stride;  // 0: not of vertices
    std::vector<unsigned char> bytes = {};
  };
  std::vector<View> views_;
  std::map<std::pair<Use, size_t>, int> shared_;  // the view for accessors of one use and stride
  Json accessors_ = Json::array();
};

}  // namespace skinlod
