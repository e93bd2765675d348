// SPDX-License-Identifier: MIT
#include "tools/progress.h"

#include <doctest/doctest.h>

#include <sstream>

namespace skinlod {

TEST_SUITE("progress") {
  TEST_CASE("the bar shows stage and percentage and wipes itself away") {
    std::ostringstream out;
    {
      ProgressBar bar(out, true);
      bar("collapsing", 0.5);
      CHECK(out.str() == "\r\x1b[K[############............]  50 % collapsing");
      const size_t before = out.str().size();
      bar("collapsing", 0.501);  // nothing to be seen has changed
      CHECK(out.str().size() == before);
      bar("collapsing", 7);
      CHECK(out.str().ends_with("[########################] 100 % collapsing"));
    }
    CHECK(out.str().ends_with("collapsing\r\x1b[K"));
  }
  TEST_CASE("a bar that is not shown writes nothing") {
    std::ostringstream out;
    { ProgressBar(out, false)("collapsing", 0.5); }
    CHECK(out.str().empty());
  }
  TEST_CASE("a string is no terminal") { CHECK_FALSE(is_terminal(std::ostringstream())); }
}

}  // namespace skinlod
