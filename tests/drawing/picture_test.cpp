// SPDX-License-Identifier: MIT
#include "tools/drawing/picture.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace skinlod {

TEST_SUITE("drawing") {
  TEST_CASE("a picture comes back from its PNG") {
    Picture picture(7, 5, 0);
    for (size_t i = 0; i < picture.bytes.size(); ++i) picture.bytes[i] = std::uint8_t(37 * i);
    const auto bytes = png(picture);
    const auto* begin = reinterpret_cast<const unsigned char*>(bytes.data());
    const Picture back = decode_image({begin, bytes.size()});
    CHECK(back.width == 7);
    CHECK(back.height == 5);
    CHECK(back.bytes == picture.bytes);
    CHECK(decode_image({begin, bytes.size() / 2}).bytes != picture.bytes);
  }

  TEST_CASE("text and pictures stay inside what they are put into") {
    Picture page(60, 30);
    write_text(page, "LOD2", 4, 6);
    CHECK(std::ranges::count(page.bytes, 40) > 100);
    Picture narrow(10, 10);
    write_text(narrow, "LOD2: 1,234 triangles", 4, 3);
    paste(narrow, Picture(20, 20, 9), 6, 7);
    CHECK(narrow.bytes.size() == 300);
    CHECK(std::ranges::count(narrow.bytes, 9) == 3 * 4 * 3);
  }
}

}  // namespace skinlod
