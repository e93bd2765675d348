// SPDX-License-Identifier: MIT
#include "tools/suggest.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

namespace skinlod {

TEST_SUITE("suggest") {
  const std::vector<std::string> kNames = {"--lods", "--poses", "--pose-clip", "--max-influences",
                                           "--report"};

  TEST_CASE("a slip of the finger finds the name that was meant") {
    CHECK(closest("--lod", kNames) == "--lods");
    CHECK(closest("--psoes", kNames) == "--poses");
    CHECK(closest("--reprot", kNames) == "--report");
    CHECK(closest("--pose-clips", kNames) == "--pose-clip");
  }
  TEST_CASE("half a name finds the whole one") {
    CHECK(closest("--influences", kNames) == "--max-influences");
  }
  TEST_CASE("what is far from every name gets no suggestion") {
    CHECK_FALSE(closest("--watermark", kNames));
    CHECK_FALSE(closest("", kNames));
    CHECK_FALSE(closest("--lods", {}));
  }
}

}  // namespace skinlod
