// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace skinlod {

/// Rows of pixels from the top, three bytes each: red, green, blue as screens have them.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> bytes{};

  /// Of one grey.
  Picture(int wide, int high, std::uint8_t grey = 255)
      : width(wide), height(high), bytes(3 * size_t(wide) * size_t(high), grey) {}
};

/// Puts `from` into `to`, its upper left corner at x, y. What does not fit is left out.
void paste(Picture& to, const Picture& from, int x, int y);

/// Dark letters of 14 pixels' height (ASCII), their upper left corner at x, y.
void write_text(Picture& to, const std::string& text, int x, int y);

/// The bytes of a PNG file.
std::vector<std::byte> png(const Picture& picture);

/// A PNG or JPEG; of no size where it is neither.
Picture decode_image(std::span<const unsigned char> encoded);

}  // namespace skinlod
