// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/tools/harness.h"
#include "tests/tools/schema.h"

namespace skinlod {
namespace {

using nlohmann::json;

// A cook of the tube with two levels, and what evaluate says of a file of it.
struct CookedTube {
  TemporaryFolder folder;
  CookedTube() {
    REQUIRE(skinlod({"cook", "test:tube", "-o", folder / "hero.slod", "--lods", "50%,20%", "--gltf",
                     folder / "g"})
                .code == 0);
  }
  Outcome evaluate(std::vector<std::string> more) const {
    std::vector<std::string> args = {
        "evaluate", "test:tube", folder / "hero.slod", "--samples", "2000", "--frames", "6", "--rom", "3"};
    args.insert(args.end(), more.begin(), more.end());
    return skinlod(args);
  }
};

}  // namespace

TEST_SUITE("evaluate_command") {
  TEST_CASE("the levels of a .slod are measured and the report is as the schema says") {
    const CookedTube cooked;
    const Outcome told = cooked.evaluate({"--json"});
    CAPTURE(told.err);
    REQUIRE(told.code == 0);
    const json report = json::parse(told.out);
    const json schema = json::parse(contents("tools/report.schema.json"));
    CHECK(schema_violations(report, schema, schema) == std::vector<std::string>{});
    CHECK(report["kind"] == "evaluation");
    CHECK(told.out.find(cooked.folder / "") == std::string::npos);
    REQUIRE(report["levels"].size() == 3);
    double before = -1;
    for (const json& level : report["levels"]) {
      const double rms = level["clips"]["rms_metres"];
      CHECK(rms > before);
      before = rms;
      CHECK(level["poses"].size() == 1 + 6 + 3);
      CHECK(level["by_joint"].size() == 4);
      CHECK(level["worst"]["joint"] != "");
      double worst = 0;
      for (const json& pose : level["poses"])
        worst = std::max(worst, pose["error"]["max_metres"].get<double>());
      CHECK(worst ==
            std::max({level["rest"]["max_metres"].get<double>(), level["clips"]["max_metres"].get<double>(),
                      level["motion"]["max_metres"].get<double>()}));
    }
    CHECK(report["levels"][0]["clips"]["rms_percent"] < 0.01);  // level 0 is the source but for its bits
    CHECK(report["levels"][0]["uv"]["rms"] < 0.01);
  }
  TEST_CASE("a GLB of the level measures as the level in the .slod") {
    const CookedTube cooked;
    const json both = json::parse(skinlod({"evaluate", "test:tube", cooked.folder / "hero.slod",
                                           cooked.folder / "g/hero_lod2.glb", "--json"})
                                      .out);
    REQUIRE(both["levels"].size() == 4);
    CHECK(both["levels"][3]["lod"].is_null());
    CHECK(both["levels"][3]["file"] == "hero_lod2.glb");
    CHECK(both["levels"][3]["triangles"] == both["levels"][2]["triangles"]);
    const double a = both["levels"][2]["clips"]["rms_metres"], b = both["levels"][3]["clips"]["rms_metres"];
    CHECK(a == doctest::Approx(b).epsilon(0.01));
    CHECK(a != 0);
  }
  TEST_CASE("morph targets are poses, matched by name, and clips turn them on") {
    const TemporaryFolder folder;
    REQUIRE(skinlod({"cook", "test:smile", "-o", folder / "hero.slod", "--lods", "20%"}).code == 0);
    REQUIRE(skinlod({"cook", "test:smile", "-o", folder / "bare.slod", "--lods", "20%", "--morphs", "none"})
                .code == 0);
    const auto evaluated = [&](const std::string& file, const std::string& targets) {
      const Outcome told = skinlod({"evaluate", "test:smile", folder / file, "--samples", "2000", "--frames",
                                    "6", "--rom", "0", "--targets", targets, "--json"});
      CAPTURE(told.err);
      REQUIRE(told.code == 0);
      const json report = json::parse(told.out);
      const json schema = json::parse(contents("tools/report.schema.json"));
      CHECK(schema_violations(report, schema, schema) == std::vector<std::string>{});
      return report;
    };
    const json ours = evaluated("hero.slod", "24"), bare = evaluated("bare.slod", "24");
    CHECK(ours["poses"]["morphs"] == 2);
    REQUIRE(ours["levels"].size() == 2);
    CHECK(ours["levels"][1]["poses"].size() == 1 + 6 + 2);
    CHECK(ours["levels"][1]["poses"][7]["name"] == "morph bulge");
    CHECK(ours["levels"][0]["morphs"]["max_percent"] < 0.01);
    CHECK(ours["levels"][1]["morphs"]["rms_metres"] <
          0.5 * bare["levels"][1]["morphs"]["rms_metres"].get<double>());
    // Without the targets nothing of the bulge, half a metre high, is there: not at rest, not in the clip.
    CHECK(bare["levels"][0]["morphs_missing"] == json{"bulge", "twitch"});
    CHECK(bare["levels"][0]["rest"]["max_percent"] < 0.01);
    CHECK(bare["levels"][0]["morphs"]["max_metres"] > 0.3);
    CHECK(bare["levels"][0]["clips"]["max_metres"] > 0.2);
    CHECK(ours["levels"][0]["clips"]["rms_percent"] < 0.01);  // 8 bits of weight
    CHECK(evaluated("hero.slod", "1")["levels"][0]["poses"].size() == 1 + 6 + 1);
    CHECK(evaluated("hero.slod", "0")["levels"][0]["morphs"].is_null());
  }

  TEST_CASE("people get a table and spreadsheets a line per level and pose") {
    const CookedTube cooked;
    const Outcome table = cooked.evaluate({});
    CHECK(table.code == 0);
    for (const char* told : {"test:tube: ", "hero.slod LOD2", "range of", "worst in\n"}) {
      CAPTURE(told);
      CHECK(table.out.find(told) != std::string::npos);
    }
    const std::string csv = cooked.evaluate({"--csv"}).out;
    CHECK(csv.starts_with("file,lod,triangles,pose,rms_metres"));
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 1 + 3 * 10);
    CHECK(cooked.evaluate({"--csv", "--threads", "1"}).out == csv);
    CHECK(cooked.evaluate({"--csv", "--threads", "2"}).out == csv);
  }
  TEST_CASE("what cannot be compared is refused with a reason") {
    const CookedTube cooked;
    const auto refused = [](const std::vector<std::string>& args, int code, const std::string& words) {
      const Outcome outcome = skinlod(args);
      CAPTURE(outcome.err);
      CHECK(outcome.code == code);
      CHECK(outcome.out.empty());
      CHECK(outcome.err.find(words) != std::string::npos);
    };
    refused({"evaluate", "test:tube"}, 2, "CANDIDATE: missing");
    refused({"evaluate"}, 2, "ORIGINAL: missing");
    refused({"evaluate", cooked.folder / "hero.slod", "test:tube"}, 3, "is no original");
    refused({"evaluate", "test:tube", cooked.folder / "none.glb"}, 4, "none.glb");
    refused({"evaluate", "test:tube", "content/humanoid.glb"}, 3, "of its joints are not in the original");
    refused({"evaluate", "test:tube", cooked.folder / "hero.slod", "--json", "--csv"}, 2, "contradicts");
  }
}

}  // namespace skinlod
