// SPDX-License-Identifier: MIT
#include "tools/drawing/picture.h"

#include <algorithm>
#include <array>
#include <cstring>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_easy_font.h>
#pragma GCC diagnostic pop
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>

namespace skinlod {
namespace {

void fill(Picture& to, int left, int top, int right, int bottom, std::uint8_t grey) {
  const int first = std::clamp(left, 0, to.width), last = std::clamp(right, first, to.width);
  for (int y = std::max(top, 0); y < std::min(bottom, to.height); ++y) {
    std::uint8_t* row = to.bytes.data() + 3 * size_t(y) * size_t(to.width);
    std::fill(row + 3 * first, row + 3 * last, grey);
  }
}

}  // namespace

void paste(Picture& to, const Picture& from, int x, int y) {
  const int columns = std::min(from.width, to.width - x), rows = std::min(from.height, to.height - y);
  for (int r = 0; r < rows && columns > 0; ++r) {
    std::memcpy(to.bytes.data() + 3 * (size_t(y + r) * size_t(to.width) + size_t(x)),
                from.bytes.data() + 3 * size_t(r) * size_t(from.width), 3 * size_t(columns));
  }
}

void write_text(Picture& to, const std::string& text, int x, int y) {
  constexpr int kScale = 2;
  struct Corner {
    float x, y, z;
    std::array<std::uint8_t, 4> colour;
  };
  std::vector<Corner> corners(4 * 32 * (text.size() + 1));  // no letter has more than 32 bars
  std::string line = text;
  const int bars =
      stb_easy_font_print(0, 0, line.data(), nullptr, corners.data(), int(corners.size() * sizeof(Corner)));
  for (size_t b = 0; b < size_t(bars); ++b) {
    const Corner &from = corners[4 * b], &until = corners[4 * b + 2];
    fill(to, x + kScale * int(from.x), y + kScale * int(from.y), x + kScale * int(until.x),
         y + kScale * int(until.y), 40);
  }
}

std::vector<std::byte> png(const Picture& picture) {
  std::vector<std::byte> file;
  const auto append = [](void* to, void* bytes, int size) {
    const auto* begin = static_cast<const std::byte*>(bytes);
    auto& all = *static_cast<std::vector<std::byte>*>(to);
    all.insert(all.end(), begin, begin + size);
  };
  stbi_write_png_to_func(append, &file, picture.width, picture.height, 3, picture.bytes.data(),
                         3 * picture.width);
  return file;
}

Picture decode_image(std::span<const unsigned char> encoded) {
  int width = 0, height = 0, channels = 0;
  std::uint8_t* pixels =
      stbi_load_from_memory(encoded.data(), int(encoded.size()), &width, &height, &channels, 3);
  if (!pixels) return {0, 0};
  Picture picture(width, height);
  std::memcpy(picture.bytes.data(), pixels, picture.bytes.size());
  stbi_image_free(pixels);
  return picture;
}

}  // namespace skinlod
