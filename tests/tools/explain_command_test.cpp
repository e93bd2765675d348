// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "pipeline/warning.h"
#include "tests/tools/harness.h"

namespace skinlod {

TEST_SUITE("explain_command") {
  TEST_CASE("every code is listed and explained with cause, mending and remedy") {
    const Outcome list = skinlod({"explain"});
    CHECK(list.code == 0);
    CHECK(list.err.empty());
    REQUIRE(!warning_codes().empty());
    for (const WarningCode code : warning_codes()) {
      const std::string its(name(code));
      CAPTURE(its);
      CHECK(list.out.find("  " + its + " ") != std::string::npos);
      const Outcome one = skinlod({"explain", its});
      CHECK(one.code == 0);
      CHECK(one.out.starts_with(its + "\n"));
      for (const char* row : {"\n  what it means ", "\n  what skinlod did ", "\n  what you can do "})
        CHECK(one.out.find(row) != std::string::npos);
      std::istringstream lines(list.out + one.out);
      for (std::string line; std::getline(lines, line);) CHECK(line.size() <= 100);
    }
  }
  TEST_CASE("an unknown code is exit 2 with the code that was meant") {
    const Outcome near = skinlod({"explain", "weights-absnt"});
    CHECK(near.code == 2);
    CHECK(near.err == "skinlod: weights-absnt: no such code: did you mean weights-absent?\n");
    CHECK(skinlod({"explain", "x"}).err == "skinlod: x: no such code: skinlod explain lists all\n");
    CHECK(skinlod({"explain", "weights-absent", "face-duplicate"}).code == 2);
  }
}

}  // namespace skinlod
