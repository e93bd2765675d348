// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/harness.h"

namespace skinlod {

TEST_SUITE("inspect_command") {
  TEST_CASE("a source shows its parts and clips and what a cook would warn of") {
    const Outcome shown = skinlod({"inspect", "test:heavy", "--clips", "test:wave"});
    CAPTURE(shown.out);
    CHECK(shown.code == 0);
    CHECK(shown.err.empty());
    CHECK(shown.out.starts_with("test:heavy: "));
    for (const char* told : {"before welding", "influences", "bend ", "twist ", "bend (test:wave)",
                             "materials", "morph targets", "warnings (1):\n", "weights-not-normalised"}) {
      CAPTURE(told);
      CHECK(shown.out.find(told) != std::string::npos);
    }
    CHECK(skinlod({"inspect", "test:still"}).out.find("\nno clips\n") != std::string::npos);
    CHECK(skinlod({"inspect", "test:still"}).out.ends_with("warnings (0): none\n"));
  }
  TEST_CASE("the histogram counts every vertex once") {
    const auto report = nlohmann::json::parse(skinlod({"inspect", "test:tube", "--json"}).out);
    CHECK(report["kind"] == "character");
    int vertices = 0;
    for (const auto& count : report["influence_histogram"]) vertices += count.get<int>();
    CHECK(vertices == report["source"]["vertices"]);
    CHECK(report["influence_histogram"].size() == report["source"]["max_influences"].get<size_t>() + 1);
    int triangles = 0;
    for (const auto& part : report["parts"]) triangles += part["triangles"].get<int>();
    CHECK(triangles == report["source"]["triangles"]);
  }
  TEST_CASE("a cooked file shows its levels as the cook reported them") {
    const TemporaryFolder folder;
    const auto cooked = nlohmann::json::parse(
        skinlod({"cook", "test:tube", "-o", folder / "hero.slod", "--lods", "50%,100", "--json"}).out);
    const auto file = nlohmann::json::parse(skinlod({"inspect", folder / "hero.slod", "--json"}).out);
    CHECK(file["kind"] == "slod");
    CHECK(file["format_version"] == 1);
    CHECK(file["bytes"] == cooked["bytes"]);
    REQUIRE(file["levels"].size() == 3);
    for (size_t i = 0; i < 3; ++i) {
      CHECK(file["levels"][i]["triangles"] == cooked["levels"][i]["triangles"]);
      CHECK(file["levels"][i]["bytes"] == cooked["levels"][i]["bytes"]);
      CHECK(file["levels"][i]["influence_cap"] == cooked["levels"][i]["influence_cap"]);
    }
    const Outcome shown = skinlod({"inspect", folder / "hero.slod"});
    CHECK(shown.code == 0);
    CHECK(shown.out.starts_with("hero.slod: .slod version 1, "));
    CHECK(shown.out.find("\njoints (") != std::string::npos);
  }
  TEST_CASE("clips for a cooked file are refused") {
    const TemporaryFolder folder;
    put(folder / "hero.slod", "SLOD");
    const Outcome outcome = skinlod({"inspect", folder / "hero.slod", "--clips", "test:wave"});
    CHECK(outcome.code == 2);
    CHECK(outcome.err.starts_with("skinlod: --clips: hero.slod: is a .slod, "));
  }
  TEST_CASE("clips of one name from files of one name are all told apart") {
    const auto report =
        nlohmann::json::parse(skinlod({"inspect", "test:tube", "--clips", "test:wave", "--clips", "test:wave",
                                       "--clips", "test:wave", "--json"})
                                  .out);
    std::set<std::string> names;
    for (const auto& clip : report["clips"]) names.insert(clip["name"]);
    CHECK(names == std::set<std::string>{"bend", "twist", "bend (test:wave)", "bend (test:wave 2)",
                                         "bend (test:wave 3)"});
  }
  TEST_CASE("a file that is told by its name alone is refused by the loader") {
    const TemporaryFolder folder;
    put(folder / "bad.slod", "not a slod at all");
    put(folder / "short.bin", "SLOD");
    for (const char* name : {"bad.slod", "short.bin"}) {
      const Outcome outcome = skinlod({"inspect", folder / name});
      CHECK(outcome.code == 3);
      CHECK(outcome.err.find(name) != std::string::npos);
    }
    CHECK(skinlod({"inspect", folder / "missing.slod"}).code == 4);
    CHECK(skinlod({"inspect", folder / "missing.glb"}).code == 4);
  }
}

TEST_SUITE("formats_command") {
  TEST_CASE("every format is a line with its extensions") {
    const Outcome shown = skinlod({"formats"});
    CHECK(shown.code == 0);
    const auto report = nlohmann::json::parse(skinlod({"formats", "--json"}).out);
    REQUIRE(report["formats"].size() > 0);
    for (const auto& format : report["formats"]) {
      CHECK(shown.out.find(format["name"].get<std::string>()) != std::string::npos);
      for (const auto& extension : format["extensions"]) {
        CHECK(shown.out.find("." + extension.get<std::string>()) != std::string::npos);
      }
    }
  }
}

}  // namespace skinlod
