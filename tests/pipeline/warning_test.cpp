// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <set>
#include <string>

#include "pipeline/warning.h"

using namespace skinlod;

TEST_SUITE("warning") {
  TEST_CASE("every code has a name of its own in lower case with dashes") {
    std::set<std::string> names;
    const int last = int(WarningCode::ExtensionDropped);
    for (int code = 0; code <= last; ++code) {
      const std::string its(name(WarningCode(code)));
      CAPTURE(its);
      CHECK(its != "unknown");
      CHECK(its.find_first_not_of("abcdefghijklmnopqrstuvwxyz-") == std::string::npos);
      names.insert(its);
      const Explanation texts = explain(WarningCode(code));
      for (const std::string_view text : {texts.meaning, texts.done, texts.remedy})
        CHECK(text.ends_with("."));
    }
    CHECK(int(warning_codes().size()) == last + 1);
    CHECK(int(names.size()) == last + 1);
    CHECK(name(WarningCode(last + 1)) == "unknown");
  }

  TEST_CASE("equal findings are counted up and none is never listed") {
    Warnings warnings;
    warn(warnings, {WarningCode::FaceDegenerate, "body", 2});
    warn(warnings, {WarningCode::FaceDegenerate, "body", 3});
    warn(warnings, {WarningCode::FaceDegenerate, "head", 1});
    warn(warnings, {WarningCode::FaceDuplicate, "body", 1});
    warn(warnings, {WarningCode::FaceDuplicate, "body", 1, "removed"});
    warn(warnings, {WarningCode::WeightsAbsent, "body", 0});
    REQUIRE(warnings.size() == 4);
    CHECK(warnings[0].count == 5);
    CHECK(warnings[1].part == "head");
  }

  TEST_CASE("the text names part and count and code and detail where they are there") {
    CHECK(text({WarningCode::WeightsNotNormalised, "body", 12, "scaled"}) ==
          "body: 12 x weights-not-normalised (scaled)");
    CHECK(text({WarningCode::JointUnused, "", 1}) == "1 x joint-unused");
  }
}
