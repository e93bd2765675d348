// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>
#include <sys/stat.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/tools/harness.h"

namespace skinlod {
namespace {

using nlohmann::json;
using Names = std::set<std::string>;

// A cook of `test:tube` into `folder`, plus what is given.
Outcome cook_tube(const TemporaryFolder& folder, std::vector<std::string> more = {}) {
  std::vector<std::string> args = {"cook", "test:tube", "-o", folder / "hero.slod"};
  args.insert(args.end(), more.begin(), more.end());
  return skinlod(args);
}

}  // namespace

TEST_SUITE("cook_command") {
  TEST_CASE("a cook writes the file and shows the levels") {
    const TemporaryFolder folder;
    const Outcome cooked = cook_tube(folder);
    CAPTURE(cooked.err);
    CHECK(cooked.code == 0);
    CHECK(cooked.err.empty());  // also: no progress where there is no terminal
    CHECK(folder.names() == Names{"hero.slod"});
    CHECK(contents(folder / "hero.slod").starts_with("SLOD"));
    for (const char* level : {"LOD0 ", "LOD1 ", "LOD2 ", "LOD3 ", "LOD4 "}) {
      CHECK(cooked.out.find(std::string("\n") + level) != std::string::npos);
    }
    CHECK(cooked.out.starts_with("test:tube: "));
    CHECK(cooked.out.find("100 %") != std::string::npos);
    CHECK(cooked.out.find("range of") != std::string::npos);
  }
  TEST_CASE("quiet is quiet and the table stands aside for other results") {
    const TemporaryFolder folder;
    CHECK(cook_tube(folder, {"--quiet"}).out.empty());
    CHECK(nlohmann::json::accept(cook_tube(folder, {"--json"}).out));
    const Outcome piped = skinlod({"cook", "test:tube", "-o", "-"});
    CHECK(piped.code == 0);
    CHECK(piped.out == contents(folder / "hero.slod"));
  }
  TEST_CASE("each output is asked for and none comes along") {
    const TemporaryFolder folder;
    const Outcome cooked = cook_tube(folder, {"--lods", "50%,25%", "--gltf", folder / "new/lods", "--report",
                                              folder / "hero.json", "--depfile", folder / "hero.d"});
    CAPTURE(cooked.err);
    CHECK(cooked.code == 0);
    CHECK(folder.names() == Names{"hero.slod", "hero.json", "hero.d", "new/", "new/lods/",
                                  "new/lods/hero_lod0.glb", "new/lods/hero_lod1.glb",
                                  "new/lods/hero_lod2.glb"});
    CHECK(contents(folder / "hero.d") == (folder / "hero.slod") + ": \\\n  test\\:tube\n");
    CHECK(contents(folder / "hero.json") ==
          cook_tube(folder, {"--lods", "50%,25%", "--gltf", folder / "new/lods", "--json"}).out);
  }
  TEST_CASE("without level 0 the levels keep their numbers") {
    const TemporaryFolder folder;
    const Outcome cooked = cook_tube(folder, {"--no-lod0", "--lods", "50%", "--gltf", folder / "lods"});
    CHECK(cooked.code == 0);
    CHECK(folder.names() == Names{"hero.slod", "lods/", "lods/hero_lod1.glb"});
    CHECK(cooked.out.find("\nLOD0 ") == std::string::npos);
    CHECK(cooked.out.find("\nLOD1 ") != std::string::npos);
  }
  TEST_CASE("the bytes do not depend on the number of threads nor on the run") {
    const TemporaryFolder folder;
    CHECK(cook_tube(folder, {"--report", folder / "r1", "--threads", "1"}).code == 0);
    const std::string first = contents(folder / "hero.slod");
    CHECK(cook_tube(folder, {"--report", folder / "r2", "--threads", "2"}).code == 0);
    CHECK(first == contents(folder / "hero.slod"));
    CHECK(contents(folder / "r1") == contents(folder / "r2"));
  }
  TEST_CASE("clips of other files are counted and named apart") {
    const TemporaryFolder folder;
    const Outcome cooked = cook_tube(folder, {"--clips", "test:wave", "--report", folder / "r.json",
                                              "--depfile", folder / "d", "--pose-clip", "bend (test:wave)"});
    CAPTURE(cooked.err);
    CHECK(cooked.code == 0);
    CHECK(cooked.out.find("test:wave: 3 of 4 channels bound, 1 clip\n") != std::string::npos);
    const auto report = nlohmann::json::parse(contents(folder / "r.json"));
    const auto clips = nlohmann::json::parse(R"json(
        [{"file": "test:wave", "clips": ["bend (test:wave)"], "channels": 4, "bound": 3}])json");
    CHECK(report["clip_files"] == clips);
    CHECK(contents(folder / "d").ends_with("test\\:tube \\\n  test\\:wave\n"));
  }
  TEST_CASE("several inputs are cooked as one character, and what they share is one vertex") {
    const TemporaryFolder folder;
    const std::vector<std::string> both = {
        "cook",     "test:lower",      "test:upper", "-o",        folder / "both.slod",
        "--report", folder / "r.json", "--depfile",  folder / "d"};
    const Outcome cooked = skinlod(both);
    CAPTURE(cooked.err);
    CHECK(cooked.code == 0);
    CHECK(cooked.out.starts_with("test:lower + test:upper: "));
    CHECK(contents(folder / "d").ends_with("test\\:lower \\\n  test\\:upper\n"));
    CHECK(cook_tube(folder, {"--report", folder / "whole.json"}).code == 0);
    const auto ours = nlohmann::json::parse(contents(folder / "r.json"));
    const auto whole = nlohmann::json::parse(contents(folder / "whole.json"));
    CHECK(ours["source"]["vertices"] == whole["source"]["vertices"]);
    CHECK(ours["source"]["parts"] == 2);
    CHECK(ours["options"]["lock_open_borders"] == false);
    CHECK(skinlod({"cook", "test:lower", "test:lower", "-o", folder / "x.slod"}).code == 2);
  }
  TEST_CASE("a lock on open borders and merged materials are told in the report") {
    const TemporaryFolder folder;
    const Outcome cooked = skinlod({"cook", "test:lower", "-o", folder / "a.slod", "--json",
                                    "--lock-open-borders", "--merge-materials"});
    CHECK(cooked.code == 0);
    const auto options = nlohmann::json::parse(cooked.out)["options"];
    CHECK(options["lock_open_borders"] == true);
    CHECK(options["merge_materials"] == true);
    const std::string locked = contents(folder / "a.slod");
    CHECK(skinlod({"cook", "test:lower", "-o", folder / "a.slod", "-q"}).code == 0);
    CHECK(locked != contents(folder / "a.slod"));
  }
  TEST_CASE("a target that cannot be reached is exit 1 with a reason after all is written") {
    const TemporaryFolder folder;
    const Outcome cooked = cook_tube(folder, {"--lods", "50%,1", "--report", folder / "r.json"});
    CHECK(cooked.code == 1);
    CHECK(cooked.err.starts_with("skinlod: test:tube: LOD2: asked for 1 triangles (1 triangles), got "));
    CHECK(std::count(cooked.err.begin(), cooked.err.end(), '\n') == 1);
    CHECK(folder.names() == Names{"hero.slod", "r.json"});
    const auto levels = nlohmann::json::parse(contents(folder / "r.json"))["levels"];
    REQUIRE(levels.size() == 3);
    CHECK(levels[1]["reached"] == true);
    CHECK(levels[1]["reason"] == "");
    CHECK(levels[2]["reached"] == false);
    CHECK(levels[2]["reason"] != "");
    CHECK(levels[2]["asked_triangles"] == 1);
    CHECK(levels[2]["triangles"] > 1);
  }
  TEST_CASE("joints leave as asked and the report says who and at what cost") {
    const TemporaryFolder folder;
    const Outcome cooked = cook_tube(folder, {"--lods", "50%,20%", "--joints-per-lod", "3,2", "--keep-joint",
                                              "*3", "--report", folder / "r.json"});
    CAPTURE(cooked.err);
    CHECK(cooked.code == 0);
    CHECK(cooked.out.find("joints") != std::string::npos);
    const auto report = nlohmann::json::parse(contents(folder / "r.json"));
    CHECK(report["options"]["keep_joints"] == nlohmann::json{"*3"});
    const auto& levels = report["levels"];
    REQUIRE(levels.size() == 3);
    std::set<std::string> left;
    for (size_t l = 0; l < 3; ++l) {
      CHECK(levels[l]["joints"] == 4 - l);
      REQUIRE(levels[l]["joints_left"].size() == (l == 0 ? 0 : 1));
      if (l == 0) continue;
      const auto& one = levels[l]["joints_left"][0];
      left.insert(one["joint"].get<std::string>());
      CHECK(one["cost_metres"] > 0);
      CHECK(one["cost_percent"].get<double>() ==
            doctest::Approx(100 * one["cost_metres"].get<double>() /
                            report["source"]["diagonal_metres"].get<double>()));
    }
    CHECK(left.size() == 2);
    CHECK_FALSE(left.contains("joint3"));
    CHECK(levels[1]["target"] == "50% and 3 joints");
    const auto file = nlohmann::json::parse(skinlod({"inspect", folder / "hero.slod", "--json"}).out);
    for (size_t l = 0; l < 3; ++l) CHECK(file["levels"][l]["joints"] == levels[l]["joints"]);
  }
  TEST_CASE("more joints that must stay than may is exit 1 with a reason") {
    const TemporaryFolder folder;
    const Outcome cooked =
        cook_tube(folder, {"--lods", "50%", "--joints-per-lod", "2", "--keep-joint", "joint*"});
    CHECK(cooked.code == 1);
    CHECK(cooked.err.find(": LOD1: asked for 50% and 2 joints (") != std::string::npos);
    CHECK(cooked.err.ends_with(": 4 joints are left and must stay: allow more, or keep fewer\n"));
    CHECK(folder.names() == Names{"hero.slod"});
  }
  TEST_CASE("what makes no sense about joints is refused before the work") {
    const TemporaryFolder folder;
    const auto refused = [&](std::vector<std::string> more) {
      const Outcome outcome = cook_tube(folder, std::move(more));
      CHECK(outcome.code == 2);
      CHECK(folder.names().empty());
      return outcome.err;
    };
    CHECK(refused({"--joints-per-lod", "3", "--joint-error", "1%"}) ==
          "skinlod: --joint-error: contradicts --joints-per-lod: give one of them\n");
    CHECK(refused({"--joints-per-lod", "3", "--metric", "rest_pose"}) ==
          "skinlod: --joints-per-lod: needs --metric articulated: the others solve for no weights\n");
    CHECK(refused({"--keep-joint", "joint1"}) ==
          "skinlod: --keep-joint: no joint would leave: give --joints-per-lod or --joint-error too\n");
    CHECK(refused({"--joints-per-lod", "3", "--keep-joint", "jiont1"}) ==
          "skinlod: --keep-joint: no joint is called 'jiont1': did you mean 'joint1'?\n");
    CHECK(refused({"--joint-error", "1%", "--keep-joint", "hand_*"}) ==
          "skinlod: --keep-joint: no joint is called 'hand_*': the first of them is 'joint0'\n");
  }
  TEST_CASE("importance is told in the report, changes the levels and not their number of triangles") {
    const TemporaryFolder folder;
    const auto report = [&](std::vector<std::string> more) {
      more.insert(more.end(), {"--lods", "20%", "--json"});
      const Outcome cooked = cook_tube(folder, more);
      CAPTURE(cooked.err);
      REQUIRE(cooked.code == 0);
      return json::parse(cooked.out);
    };
    const json plain = report({});
    const std::string bytes = contents(folder / "hero.slod");
    CHECK(plain["options"]["importance"].empty());
    report({"--importance", "joint?=1"});
    CHECK(contents(folder / "hero.slod") == bytes);
    const json told = report({"--importance", "joint3=4", "--importance", "material:sk*=0.5"});
    CHECK(contents(folder / "hero.slod") != bytes);
    const json& all = told["options"]["importance"];
    REQUIRE(all.size() == 2);
    CHECK(all[0]["select"] == "joint3");
    CHECK(all[0]["factor"] == 4);
    CHECK(all[0]["vertices"] > 0);
    CHECK(all[0]["vertices"] < told["source"]["vertices"]);
    CHECK(all[1]["select"] == "material:sk*");
    CHECK(all[1]["vertices"] == told["source"]["vertices"]);
    CHECK(told["levels"][1]["triangles"] == plain["levels"][1]["triangles"]);
  }
  TEST_CASE("importance that selects nothing or is misspelt is exit 2 with a remedy") {
    const TemporaryFolder folder;
    const auto refused = [&](const std::string& selection) {
      const Outcome outcome = cook_tube(folder, {"--importance", selection});
      CHECK(outcome.code == 2);
      CHECK(folder.names().empty());
      CHECK(outcome.err.starts_with("skinlod: --importance: "));
      return outcome.err.substr(std::string("skinlod: --importance: ").size());
    };
    for (const char* bare : {"joint1", "=4", ""}) {
      CHECK(refused(bare) == "'" + std::string(bare) +
                                 "' is no selection with a factor: write head*=4, material:skin=4 or "
                                 "color:r=4\n");
    }
    for (const char* factor : {"joint1=", "joint1=four", "joint1=0", "joint1=-2", "joint1=101", "joint1=nan"})
      CHECK(refused(factor) == "'" + std::string(factor) + "': a factor is 0.01 to 100\n");
    CHECK(refused("jiont1=4") == "no joint is called 'jiont1': did you mean 'joint1'?\n");
    CHECK(refused("Joint1*=4") == "no joint is called 'Joint1*': did you mean 'joint1'?\n");
    CHECK(refused("skin=4") == "no joint is called 'skin': did you mean 'material:skin'?\n");
    CHECK(refused("colour:r=4") == "no joint is called 'colour:r': did you mean 'color:r'?\n");
    CHECK(refused("head*=4") == "no joint is called 'head*': the first of them is 'joint0'\n");
    CHECK(refused("material:skim=4") == "no material is called 'skim': did you mean 'skin'?\n");
    CHECK(refused("color:x=4") == "a colour has no channel 'x': give color:r, color:g, color:b or color:a\n");
    CHECK(refused("color:r=4") ==
          "color:r: the character has no colours: paint some, or give a pattern of joints\n");
  }
  TEST_CASE("a warning is told and under --strict it is exit 3 and nothing is written") {
    const TemporaryFolder folder;
    const std::vector<std::string> args = {"cook", "test:heavy", "-o", folder / "hero.slod"};
    std::vector<std::string> strictly = args, quietly = args;
    strictly.push_back("--strict"), quietly.push_back("-q");

    const Outcome strict = skinlod(strictly);
    CHECK(strict.code == 3);
    CHECK(strict.err.starts_with("skinlod: test:heavy: has warnings, and --strict allows none: "));
    CHECK(strict.err.find("weights-not-normalised") != std::string::npos);
    CHECK(strict.out.empty());
    CHECK(folder.names().empty());

    const Outcome lenient = skinlod(args);
    CHECK(lenient.code == 0);
    CHECK(lenient.err.starts_with("skinlod: warning: "));
    CHECK(lenient.err.find("weights-not-normalised") != std::string::npos);
    CHECK(skinlod(quietly).err.empty());
    CHECK(cook_tube(folder, {"--strict"}).code == 0);  // and what has none passes
  }
  TEST_CASE("verbose tells the files and the poses on standard error") {
    const TemporaryFolder folder;
    const Outcome cooked = cook_tube(folder, {"-v"});
    CHECK(cooked.err.starts_with("read test:tube\n"));
    CHECK(cooked.err.find("\nexample pose: bind\n") != std::string::npos);
    CHECK(cooked.err.find("\ncollapse ") != std::string::npos);
  }
  TEST_CASE("what each stage took is told apart from all that must not change") {
    const TemporaryFolder folder;
    const Outcome plain = cook_tube(folder, {"--json"});
    const std::string slod = contents(folder / "hero.slod");
    const Outcome timed = cook_tube(folder, {"--json", "--timings", folder / "t.json"});
    CHECK(timed.out == plain.out);
    CHECK(contents(folder / "hero.slod") == slod);
    std::vector<std::string> names;
    double wall = 0, peak = 0;
    const json timings = json::parse(contents(folder / "t.json"));
    for (const json& stage : timings["stages"]) {
      names.push_back(stage["stage"]);
      wall += stage["wall_seconds"].get<double>();
      peak = std::max(peak, stage["peak_megabytes"].get<double>());
      CHECK(stage["cpu_seconds"] >= 0);
    }
    CHECK(names == std::vector<std::string>{"reading", "repairing", "choosing poses", "quadrics", "collapse",
                                            "fit", "measure", "packing", "writing"});
    CHECK(wall > 0);
    CHECK(peak > 1);
  }
  TEST_CASE("morph targets are measured, and those that move nothing are listed level by level") {
    const TemporaryFolder folder;
    const auto report = [&](const std::string& use) {
      const Outcome outcome =
          skinlod({"cook", "test:smile", "-o", folder / "hero.slod", "--gltf", folder / "g", "--lods",
                   "50%,10%", "--poses", "2", "--rom", "0", "--morphs", use, "--json"});
      CAPTURE(outcome.err);
      REQUIRE(outcome.code == 0);
      return json::parse(outcome.out);
    };
    const json all = report("keep");
    CHECK(all["poses"]["morphs"] == json{"morph bulge", "morph twitch"});
    CHECK(all["levels"][2]["error"]["morphs"]["rms_metres"] > 0);
    for (const json& level : all["levels"]) CHECK(level["dropped_morphs"] == json{"still"});
    // 2 mm are more than the first level is off, and less than the second is.
    const json important = report("important");
    CHECK(important["levels"][1]["dropped_morphs"] == json{"still"});
    CHECK(important["levels"][2]["dropped_morphs"] == json{"twitch", "still"});
    CHECK(important["levels"][1]["error"] == all["levels"][1]["error"]);
    // The tool's own levels, measured by the tool: the candidate has the dropped target, and it moves
    // nothing.
    const Outcome told = skinlod({"evaluate", "test:smile", folder / "hero.slod", folder / "g/hero_lod1.glb",
                                  "--frames", "2", "--rom", "0", "--samples", "2000", "--json"});
    REQUIRE(told.code == 0);
    for (const json& level : json::parse(told.out)["levels"]) CHECK(level["morphs_missing"].empty());

    const json none = report("none");
    CHECK(none["source"]["morphs"] == 0);
    CHECK(none["poses"]["morphs"].empty());
    CHECK(none["levels"][2]["error"]["morphs"].is_null());
    CHECK(none["levels"][2]["dropped_morphs"].empty());
    const Outcome bare = skinlod(
        {"evaluate", "test:smile", folder / "hero.slod", "--frames", "2", "--rom", "0", "--samples", "2000"});
    REQUIRE(bare.code == 0);
    CHECK(bare.out.find("LOD0: has no bulge, nor 1 more of the morph targets: measured without\n") !=
          std::string::npos);
  }

  TEST_CASE("baselines are measured in as many triangles and change no level") {
    const TemporaryFolder folder;
    const Outcome plain = cook_tube(folder, {"--report", folder / "plain.json", "--lods", "50%,10%"});
    const std::string slod = contents(folder / "hero.slod");
    const Outcome cooked =
        cook_tube(folder, {"--report", folder / "r.json", "--lods", "50%,10%", "--baseline",
                           "meshopt_simplify,endpoint,rest_pose,pose_independent"});
    CAPTURE(cooked.err);
    CHECK(cooked.code == 0);
    CHECK(contents(folder / "hero.slod") == slod);
    CHECK(cooked.out.starts_with(plain.out));
    const std::string table = cooked.out.substr(plain.out.size());
    CHECK(std::count(table.begin(), table.end(), '\n') == 1 + 2 + 2 * 4);  // a blank, the head, two levels
    CHECK(table.find("\nLOD1   meshopt_simplify ") != std::string::npos);
    CHECK(table.find("\nLOD2 ") != std::string::npos);
    CHECK(table.find("\nLOD0 ") == std::string::npos);

    const auto levels = nlohmann::json::parse(contents(folder / "r.json"))["levels"];
    REQUIRE(levels.size() == 3);
    CHECK(levels[0]["baselines"].empty());
    for (size_t lod = 1; lod < 3; ++lod) {
      const auto& level = levels[lod];
      REQUIRE(level["baselines"].size() == 4);
      for (const auto& item : level["baselines"].items()) {
        CAPTURE(item.key());
        const auto& baseline = item.value();
        CHECK(baseline["triangles"] <= level["triangles"]);
        CHECK(baseline["triangles"] >= level["triangles"].get<int>() - 2);
        for (const char* poses : {"unseen_clip", "unseen_motion"}) {
          const double rms = baseline["error"][poses]["rms_metres"];
          CHECK(rms > 0);
          CHECK(rms <= baseline["error"][poses]["max_metres"]);
          CHECK(rms > 0.8 * level["error"][poses]["rms_metres"].get<double>());
        }
      }
    }
    for (const auto& level : nlohmann::json::parse(contents(folder / "plain.json"))["levels"])
      CHECK(level["baselines"].empty());
  }
  TEST_CASE("a baseline is what a cook with its metric would be") {
    const TemporaryFolder folder;
    CHECK(cook_tube(folder, {"--report", folder / "ours.json", "--baseline", "rest_pose"}).code == 0);
    CHECK(cook_tube(folder, {"--report", folder / "its.json", "--metric", "rest_pose"}).code == 0);
    const auto ours = nlohmann::json::parse(contents(folder / "ours.json"))["levels"];
    const auto its = nlohmann::json::parse(contents(folder / "its.json"))["levels"];
    for (size_t lod = 1; lod < ours.size(); ++lod) {
      REQUIRE(ours[lod]["triangles"] == its[lod]["triangles"]);
      const auto& baseline = ours[lod]["baselines"]["rest_pose"];
      CHECK(baseline["triangles"] == its[lod]["triangles"]);
      for (const char* poses : {"unseen_clip", "unseen_motion"}) {
        CHECK(baseline["error"][poses]["rms_metres"] == its[lod]["error"][poses]["rms_metres"]);
      }
    }
  }
  TEST_CASE("a baseline that is unknown or there twice is refused") {
    const TemporaryFolder folder;
    CHECK(cook_tube(folder, {"--baseline", "endpoint,qslim"}).err ==
          "skinlod: --baseline: 'qslim' is not known: give "
          "endpoint|meshopt_simplify|rest_pose|pose_independent\n");
    CHECK(cook_tube(folder, {"--baseline", "endpoint,endpoint"}).err ==
          "skinlod: --baseline: 'endpoint' is listed twice: list it once\n");
    CHECK(folder.names().empty());
  }
  TEST_CASE("options that contradict each other are refused") {
    const TemporaryFolder folder;
    const auto refusal = [&](std::vector<std::string> more) {
      const Outcome outcome = cook_tube(folder, more);
      CHECK(outcome.code == 2);
      return outcome.err;
    };
    CHECK(refusal({"--lods", "50%,25%,10%,5%", "--max-error", "1%"}) ==
          "skinlod: --max-error: contradicts --lods: give one of them\n");
    CHECK(refusal({"-q", "-v"}) == "skinlod: --quiet: contradicts --verbose: give one of them\n");
    CHECK(refusal({"--json", "--report", "-"}) ==
          "skinlod: stdout: can take one of -o, --report, --depfile, --timings and --json: give the others "
          "files\n");
    CHECK(refusal({"--report", folder / "hero.slod"}).ends_with("is written by -o too: name another file\n"));
    CHECK(refusal({"--lods", "50%,600"}).starts_with("skinlod: --lods: 600 triangles after 50% is finer: "));
    CHECK(refusal({"--pose-clip", "bnd"}) ==
          "skinlod: --pose-clip: there is no clip 'bnd': did you mean 'bend'?\n");
    CHECK(skinlod({"cook", "test:tube", "-o", folder / "hero.glb"}).err ==
          "skinlod: -o: " + (folder / "hero.glb") + ": would hold a .slod: write -o hero.slod --gltf DIR\n");
    CHECK(skinlod({"cook", "test:tube", "-o", "-", "--depfile", folder / "d"}).err ==
          "skinlod: --depfile: needs an output with a name: give -o FILE\n");
    CHECK(skinlod({"cook", "test:still", "-o", folder / "x.slod", "--pose-clip", "bend"}).err ==
          "skinlod: --pose-clip: there is no clip 'bend': the character has no clips\n");
    CHECK(folder.names().empty());
  }
  TEST_CASE("an input is never overwritten") {
    const TemporaryFolder folder;
    put(folder / "hero.slod", "the artist's work");
    const std::string also_hero = folder / "./hero.slod";
    const Outcome outcome = skinlod({"cook", also_hero, "-o", folder / "hero.slod"});
    CHECK(outcome.code == 2);
    CHECK(outcome.err.ends_with("is an input too, and would be overwritten: name another file\n"));

    put(folder / "run.fbx", "more work");
    std::filesystem::create_symlink("run.fbx", folder / "link");
    const Outcome clip = cook_tube(folder, {"--clips", folder / "run.fbx", "--report", folder / "link"});
    CHECK(clip.code == 2);
    CHECK(contents(folder / "hero.slod") == "the artist's work");
    CHECK(contents(folder / "run.fbx") == "more work");
  }
  TEST_CASE("what cannot be written is exit 4 before any work and leaves all as it was") {
    const TemporaryFolder folder;
    put(folder / "hero.slod", "before");
    put(folder / "file", "no folder");
    const auto refusal = [&](std::vector<std::string> more) {
      const Outcome outcome = cook_tube(folder, more);
      CHECK(outcome.code == 4);
      CHECK(outcome.out.empty());
      CHECK(contents(folder / "hero.slod") == "before");
      CHECK(folder.names() == Names{"file", "hero.slod"});
      return outcome.err;
    };
    const std::string report = folder / "missing/r.json";
    CHECK(refusal({"--report", report}) == "skinlod: --report: " + report + ": there is no folder " +
                                               (folder / "missing") + ": make it first\n");
    CHECK(refusal({"--report", folder / "file/r.json"}).ends_with("is no folder: name another place\n"));
    CHECK(refusal({"--gltf", folder / "file"}).ends_with("is no folder: name another place\n"));
    CHECK(refusal({"--gltf", folder / "file/lods"}).ends_with("is no folder: name another place\n"));
    CHECK(cook_tube(folder, {"--report", folder / ""}).code == 2);  // a folder is no file
    if (geteuid() != 0) {
      chmod((folder / "").c_str(), 0500);
      CHECK(cook_tube(folder).err.find("Permission denied") != std::string::npos);
      chmod((folder / "").c_str(), 0700);
    }
  }
  TEST_CASE("a cook that cannot write takes the folders along that it made") {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "there");
    const Outcome full = cook_tube(folder, {"--gltf", folder / "there/new/lods/", "--report", "/dev/full"});
    CHECK(full.code == 75);
    CHECK(folder.names() == Names{"there/"});
  }
  TEST_CASE("an input that is not what it should be leaves the outputs untouched") {
    const TemporaryFolder folder;
    put(folder / "hero.slod", "before");
    put(folder / "empty.glb", "");
    put(folder / "cooked.slod", "SLOD\r\n\x1a\n");
    put(folder / "prop.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const auto cook_of = [&](const std::string& input) {
      const Outcome outcome = skinlod({"cook", input, "-o", folder / "hero.slod"});
      CAPTURE(outcome.err);
      CHECK(outcome.out.empty());
      CHECK(outcome.err.starts_with("skinlod: "));
      CHECK(outcome.err.find(std::filesystem::path(input).filename().string()) != std::string::npos);
      CHECK(contents(folder / "hero.slod") == "before");
      return outcome.code;
    };
    CHECK(cook_of(folder / "no_such_file.glb") == 4);
    CHECK(cook_of(folder / "empty.glb") == 3);
    CHECK(cook_of(folder / "cooked.slod") == 3);
    CHECK(cook_of(folder / "prop.obj") == 3);
    std::filesystem::create_directory(folder / "folder");
    CHECK(cook_of(folder / "folder") == 4);
    CHECK(cook_tube(folder, {"--clips", folder / "no_such_clip.fbx"}).code == 4);
    CHECK(contents(folder / "hero.slod") == "before");
  }
}

}  // namespace skinlod
