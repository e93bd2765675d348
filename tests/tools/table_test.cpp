// SPDX-License-Identifier: MIT
#include "tools/table.h"

#include <doctest/doctest.h>

#include <cfloat>
#include <sstream>

namespace skinlod {

TEST_SUITE("table") {
  TEST_CASE("numbers are grouped in thousands") {
    CHECK(grouped(0) == "0");
    CHECK(grouped(999) == "999");
    CHECK(grouped(13832) == "13,832");
    CHECK(grouped(-1234567) == "-1,234,567");
    CHECK(grouped(-123) == "-123");
  }
  TEST_CASE("three digits are enough and none is an exponent") {
    CHECK(rounded(0) == "0");
    CHECK(rounded(1.8342) == "1.83");
    CHECK(rounded(18.342) == "18.3");
    CHECK(rounded(183.42) == "183");
    CHECK(rounded(18342) == "18342");
    CHECK(rounded(0.12345) == "0.123");
    CHECK(rounded(0.0012345) == "0.00123");
    CHECK(rounded(-2.5) == "-2.50");
    CHECK(rounded(1e-12) == "0");
    CHECK(rounded(2e-6) == "0.000002");
    CHECK(rounded(DBL_MAX).size() == 309);
    CHECK(rounded(DBL_MAX * 2) == "not finite");
  }
  TEST_CASE("columns stand under each other and lines end without blanks") {
    std::ostringstream out;
    print_table(out, {{"level", "triangles", ""}, {"LOD0", "1,000"}, {"x", "7", "mm"}});
    CHECK(out.str() == "level  triangles\nLOD0       1,000\nx              7  mm\n");
  }
}

}  // namespace skinlod
