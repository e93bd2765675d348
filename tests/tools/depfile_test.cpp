// SPDX-License-Identifier: MIT
#include "tools/depfile.h"

#include <doctest/doctest.h>

#include <vector>

#include "pipeline/error.h"
#include "tests/tools/harness.h"

namespace skinlod {

TEST_SUITE("depfile") {
  const auto rule = [](const std::string& target, std::vector<std::string> inputs) {
    return depfile(target, inputs);
  };

  TEST_CASE("it is the rule that make reads") {
    CHECK(rule("out/hero.slod", {"hero.gltf", "hero.bin"}) ==
          "out/hero.slod: \\\n  hero.gltf \\\n  hero.bin\n");
  }
  TEST_CASE("what make would read otherwise is escaped") {
    CHECK(rule("a b", {"c$d", "e#f", "g:h"}) == "a\\ b: \\\n  c$$d \\\n  e\\#f \\\n  g\\:h\n");
    CHECK(rule("x", {"back\\slash", "ends\\ here"}) == "x: \\\n  back\\slash \\\n  ends\\\\\\ here\n");
  }
  TEST_CASE("make finds files with blanks and signs by it") {
    if (std::system("command -v make >/dev/null") != 0) {
      MESSAGE("SKIPPED: make is not installed");
      return;
    }
    const TemporaryFolder folder;
    put(folder / "a b$c#d", "");
    // The input is there, so make has nothing left to make but the target; of a name misread it would
    // complain.
    put(folder / "Makefile", rule("t", {"a b$c#d"}) + "\t@echo made\n");
    CHECK(std::system(("make -s -C " + (folder / "") + " t >" + (folder / "log") + " 2>&1").c_str()) == 0);
    CHECK(contents(folder / "log") == "made\n");
  }
  TEST_CASE("a line break in a name is refused") { CHECK_THROWS_AS(rule("a\nb", {}), Error); }
}

}  // namespace skinlod
