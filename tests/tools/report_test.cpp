// SPDX-License-Identifier: MIT
#include "tools/report.h"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/harness.h"
#include "tests/tools/schema.h"

namespace skinlod {
namespace {

using nlohmann::json;

const json& schema() {
  static const json loaded = json::parse(contents("tools/report.schema.json"));
  return loaded;
}

// All findings in one text, so that a failure shows them.
std::string violations(const json& report, const json& rule = schema()) {
  std::string all;
  for (const std::string& one : schema_violations(report, rule, schema())) all += one + '\n';
  return all;
}

json cooked(const std::string& character, std::vector<std::string> more = {}) {
  const TemporaryFolder folder;
  std::vector<std::string> args = {"cook", character, "-o", folder / "hero.slod", "--json"};
  args.insert(args.end(), more.begin(), more.end());
  const Outcome outcome = skinlod(args);
  CAPTURE(outcome.err);
  REQUIRE(outcome.code == 0);
  CHECK(outcome.out.find(folder / "") == std::string::npos);  // a report holds no path
  return json::parse(outcome.out);
}

// Every path to an object key in `value`.
void each_object(json& value, const std::function<void(json&)>& visit) {
  if (value.is_object()) visit(value);
  if (value.is_structured()) {
    for (json& part : value) each_object(part, visit);
  }
}

}  // namespace

TEST_SUITE("report") {
  TEST_CASE("a cook's report is as the schema says") {
    CHECK(violations(cooked("test:tube")) == "");
    CHECK(violations(cooked("test:tube"), schema()["$defs"]["cook"]) == "");
    CHECK(violations(cooked("test:tube", {"--joint-error", "5%", "--keep-joint", "*0"})) == "");
    CHECK(violations(cooked("test:tube", {"--importance", "joint1=4", "--importance", "*=0.5"})) == "");
    CHECK(violations(cooked("test:smile", {"--morphs", "important"})) == "");
    CHECK(violations(cooked("test:heavy", {"--clips", "test:wave", "--no-lod0"})) == "");
    CHECK(violations(cooked("test:still", {"--rom", "0", "--max-error", "5%"})) == "");
    const std::vector<std::string> all = {"--baseline",
                                          "endpoint,meshopt_simplify,rest_pose,pose_independent"};
    CHECK(violations(cooked("test:tube", all)) == "");
    CHECK(violations(cooked("test:still", all)) == "");
  }
  TEST_CASE("what inspect and formats print is as the schema says") {
    const TemporaryFolder folder;
    REQUIRE(skinlod({"cook", "test:tube", "-o", folder / "hero.slod"}).code == 0);
    CHECK(violations(json::parse(skinlod({"inspect", folder / "hero.slod", "--json"}).out)) == "");
    CHECK(violations(json::parse(skinlod({"inspect", "test:heavy", "--json"}).out)) == "");
    CHECK(violations(json::parse(skinlod({"formats", "--json"}).out)) == "");
  }
  TEST_CASE("a key too few or too many anywhere is found") {
    json report = cooked("test:heavy", {"--clips", "test:wave", "--joints-per-lod", "3"});
    REQUIRE(violations(report) == "");
    int objects = 0;
    each_object(report, [&](json& object) {
      ++objects;
      object["surplus"] = 1;
      CHECK(violations(report) != "");
      object.erase("surplus");
      const json whole = object;
      for (const auto& item : whole.items()) {
        const std::string& key = item.key();
        object.erase(key);
        CAPTURE(key);
        CHECK(violations(report) != "");
        object = whole;
      }
    });
    CHECK(objects >= 20);
    CHECK(violations(report) == "");
  }
  TEST_CASE("the report tells what was cooked and how") {
    const json report = cooked("test:tube", {"--lods", "50%,100", "--max-influences", "4,2", "--seed", "7",
                                             "--poses", "3", "--rom", "2", "--metric", "rest_pose"});
    CHECK(report["schema"] == "skinlod-report");
    CHECK(report["version"] == 1);
    CHECK(report["input"] == "test:tube");
    CHECK(report["options"]["metric"] == "rest_pose");
    CHECK(report["options"]["seed"] == 7);
    CHECK(report["poses"]["examples"][0] == "bind");
    const json& levels = report["levels"];
    REQUIRE(levels.size() == 3);
    CHECK(levels[0]["target"] == "source");
    CHECK(levels[1]["target"] == "50%");
    CHECK(levels[2]["target"] == "100 triangles");
    CHECK(levels[0]["triangles"] == report["source"]["triangles"]);
    CHECK(levels[2]["triangles"] <= 100);
    CHECK(levels[2]["influence_cap"] == 2);
    CHECK(levels[2]["max_influences"] <= 2);
    CHECK(levels[2]["glb"] == nullptr);
    const json& error = levels[2]["error"]["examples"];
    const double size = report["source"]["diagonal_metres"];
    CHECK(error["rms_metres"] > 0);
    CHECK(error["rms_percent"].get<double>() ==
          doctest::Approx(100 * error["rms_metres"].get<double>() / size));
    size_t bytes = 0;
    for (const json& level : levels) bytes += level["bytes"].get<size_t>();
    CHECK(bytes <= report["bytes"].get<size_t>());
  }
  TEST_CASE("where there was no pose to measure in the error is null and not perfect") {
    const json still = cooked("test:still");
    CHECK(still["poses"]["unseen_clip"].empty());
    CHECK(still["levels"][1]["error"]["unseen_clip"] == nullptr);
    CHECK(still["levels"][1]["error"]["examples"] != nullptr);
  }
  TEST_CASE("a name that is no UTF-8 does not stop the report") {
    const std::vector<Format> formats = {{"caf\xe9", {"x"}, true, false}};
    CHECK(text(report(formats)).find("caf\xef\xbf\xbd") != std::string::npos);
  }
}

}  // namespace skinlod
