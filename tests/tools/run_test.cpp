// SPDX-License-Identifier: MIT
#include "tools/run.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "pipeline/cook.h"
#include "tests/tools/harness.h"

namespace skinlod {

TEST_SUITE("run") {
  TEST_CASE("help stands on standard output and names the commands and the exit codes") {
    for (const char* word : {"--help", "-h", "help"}) {
      const Outcome help = skinlod({word});
      CHECK(help.code == 0);
      CHECK(help.err.empty());
      for (const char* told : {"  cook ", "  inspect ", "  formats ", "Exit codes:", "  75  "}) {
        CHECK(help.out.find(told) != std::string::npos);
      }
    }
    CHECK(skinlod({"help", "cook"}).out == skinlod({"cook", "--help"}).out);
  }
  TEST_CASE("the version is one line") {
    const Outcome version = skinlod({"--version"});
    CHECK(version.code == 0);
    CHECK(version.out.starts_with("skinlod "));
    CHECK(std::count(version.out.begin(), version.out.end(), '\n') == 1);
  }
  TEST_CASE("the help of every command fits the page and ends in a line break") {
    for (const char* command : {"cook", "explain", "inspect", "formats"}) {
      const Outcome help = skinlod({command, "--help"});
      CHECK(help.code == 0);
      CHECK(help.err.empty());
      CHECK(help.out.starts_with(std::string("Usage: skinlod ") + command + " "));
      CHECK(help.out.ends_with("\n"));
      std::istringstream lines(help.out);
      for (std::string line; std::getline(lines, line);) {
        CAPTURE(line);
        CHECK(line.size() <= 100);
      }
    }
  }
  TEST_CASE("the defaults in the help are those of the pipeline") {
    const std::string help = skinlod({"cook", "--help"}).out;
    const auto line = [&](const std::string& option) {
      const size_t at = help.find("\n  " + option);
      REQUIRE(at != std::string::npos);
      return help.substr(at + 1, help.find("\n  -", at + 1) - at);
    };
    const PoseOptions poses;
    const auto value = [](auto number) { return "(default " + std::to_string(number) + ")"; };
    CHECK(line("--poses").find(value(poses.from_clips)) != std::string::npos);
    CHECK(line("--rom").find(value(poses.range_of_motion)) != std::string::npos);
    CHECK(line("--seed").find(value(poses.seed)) != std::string::npos);
    CHECK(line("--max-influences").find(value(LevelTarget{}.max_influences)) != std::string::npos);
    CHECK(line("--metric").find("(default articulated)") != std::string::npos);
    CHECK(line("--lods").find("(default 50%,25%,10%,5%)") != std::string::npos);
  }
  TEST_CASE("a wrong command line is exit 2 and says what to type") {
    const auto refusal = [](std::vector<std::string> args) {
      const Outcome outcome = skinlod(args);
      CHECK(outcome.code == 2);
      CHECK(outcome.out.empty());
      return outcome.err;
    };
    CHECK(refusal({}) == "skinlod: no command: skinlod cook HERO.glb -o HERO.slod, or see skinlod --help\n");
    CHECK(refusal({"cok"}) == "skinlod: cok: no such command: did you mean skinlod cook?\n");
    CHECK(refusal({"hero.glb"}) ==
          "skinlod: hero.glb: not a command: to cook it, skinlod cook hero.glb -o OUT.slod\n");
    CHECK(refusal({"--lods", "50%"}) == "skinlod: --lods: options follow a command: see skinlod --help\n");
    CHECK(refusal({"cook"}) == "skinlod: INPUT: missing: skinlod cook INPUT... -o OUT.slod [options]\n");
    CHECK(refusal({"cook", "test:tube"}) == "skinlod: -o: missing: say where to write, -o test:tube.slod\n");
    CHECK(refusal({"cook", "test:tube", "--otput", "x"}) ==
          "skinlod: --otput: no such option: did you mean --output?\n");
    CHECK(refusal({"cook", "test:tube", "--otput=x"}) ==
          "skinlod: --otput: no such option: did you mean --output?\n");
    CHECK(refusal({"cook", "test:tube", "--watermark"}) ==
          "skinlod: --watermark: no such option: see skinlod cook --help\n");
    CHECK(refusal({"cook", "test:tube", "hero.slod"}) ==
          "skinlod: hero.slod: one word too many: did you mean -o hero.slod?\n");
    CHECK(refusal({"cook", "test:tube", "-o", "x.slod", "--lods", "50%", "25%"}) ==
          "skinlod: 25%: one word too many: lists are written without spaces, 50%,25%\n");
    CHECK(refusal({"cook", "test:tube", "-o"}) ==
          "skinlod: --output: needs a value: see skinlod cook --help\n");
    CHECK(refusal({"cook", "test:tube", "-o", "--json"}) ==
          "skinlod: -o: needs a value: '--json' is an option\n");
    CHECK(refusal({"cook", "test:tube", "-o", ""}) ==
          "skinlod: -o: its value is empty: give one or leave it out\n");
    CHECK(refusal({"cook", "test:tube", "--poses", "1", "--poses", "2"}) ==
          "skinlod: --poses: given twice: give it once\n");
    CHECK(refusal({"cook", "test:tube", "--poses", "-1"}) ==
          "skinlod: --poses: '-1' is out of range: give 0 to 1000\n");
    CHECK(refusal({"cook", "test:tube", "--poses", "9x"}) ==
          "skinlod: --poses: '9x' is not a whole number in range: give 0 to 1000\n");
    CHECK(refusal({"cook", "test:tube", "--metric", "rest"}) ==
          "skinlod: --metric: 'rest' is not known: give articulated|pose_independent|endpoint|rest_pose\n");
    CHECK(refusal({"inspect"}) == "skinlod: FILE: missing: skinlod inspect FILE [options]\n");
  }
  TEST_CASE("a result that cannot be written is no success") {
    std::ostringstream out, err;
    out.setstate(std::ios::badbit);
    const std::vector<std::string> args = {"--version"};
    CHECK_THROWS_WITH_AS(run(args, out, err), doctest::Contains("standard output: cannot be written"), Error);
  }
}

}  // namespace skinlod
