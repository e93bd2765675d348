// SPDX-License-Identifier: MIT
#include "tools/levels.h"

#include <doctest/doctest.h>

#include "pipeline/error.h"

namespace skinlod {
namespace {

// The message of the Error{Usage} that `call` must throw.
template <class F>
std::string refusal(F call) {
  try {
    call();
  } catch (const Error& e) {
    CHECK(e.fault == Fault::Usage);
    return e.what();
  }
  return "accepted";
}

}  // namespace

TEST_SUITE("levels") {
  TEST_CASE("shares and numbers of triangles may be mixed") {
    const auto targets = parse_lods("50%, 12.5%,2000");
    REQUIRE(targets.size() == 3);
    CHECK(targets[0].ratio == 0.5);
    CHECK(targets[1].ratio == 0.125);
    CHECK(targets[2].triangles == 2000);
    CHECK_FALSE(targets[2].ratio);
    CHECK_FALSE(targets[0].max_error);
  }
  TEST_CASE("an error is a share of the diagonal") {
    const auto targets = parse_max_errors("0.1%,0.2%");
    REQUIRE(targets.size() == 2);
    CHECK(targets[1].max_error == 0.002);
    CHECK_FALSE(targets[1].ratio);
  }
  TEST_CASE("a target reads as it was written") {
    for (const char* item : {"50%", "7%", "12.5%", "0.3%", "100%", "33.3333%"}) {
      CHECK(text(parse_lods(item)[0]) == item);
      CHECK(text(parse_max_errors(item)[0]) == std::string("error ") + item);
    }
    CHECK(text(parse_lods("2000")[0]) == "2000 triangles");
  }
  TEST_CASE("what is no level is refused with what would be one") {
    const auto lods = [](const char* list) { return refusal([&] { parse_lods(list); }); };
    CHECK(lods("0%") == "--lods: '0%' is out of range: give more than 0% and at most 100% of the triangles");
    CHECK(lods("101%").starts_with("--lods: '101%' is out of range: "));
    CHECK(lods("-5%").starts_with("--lods: '-5%' is out of range: "));
    CHECK(lods("abc") ==
          "--lods: 'abc' is neither a percentage nor a number of triangles: write 50% or 5000");
    CHECK(lods("0.5").ends_with("write 50% or 5000"));
    CHECK(lods("nan%").ends_with("write 50% or 5000"));
    CHECK(lods("50%,").starts_with("--lods: '' is neither"));
    CHECK(lods("").starts_with("--lods: '' is neither"));
    CHECK(lods("0") == "--lods: '0' is out of range: give 1 to 2147483647");
    CHECK(lods("99999999999999999999").starts_with("--lods: '99999999999999999999' is not a whole number"));
    CHECK(refusal([] { parse_max_errors("0.2"); }) ==
          "--max-error: '0.2' is no percentage of the diagonal: write 0.2%");
    CHECK(refusal([] { parse_max_errors("0%"); }).starts_with("--max-error: '0%' is out of range: "));
  }
  TEST_CASE("levels go from fine to coarse") {
    CHECK(refusal([] { parse_lods("5%,50%"); }) ==
          "--lods: 50% after 5% is finer: list the levels from fine to coarse");
    CHECK(refusal([] {
            parse_lods("100,200");
          }).starts_with("--lods: 200 triangles after 100 triangles is finer: "));
    CHECK(refusal([] {
            parse_max_errors("1%,0.1%");
          }).starts_with("--max-error: error 0.1% after error 1% is finer"));
    const auto mixed = parse_lods("50%,400");  // which of the two is finer is the source's affair
    CHECK_NOTHROW(check_order(mixed, 1000));
    CHECK(
        refusal([&] { check_order(mixed, 700); }).starts_with("--lods: 400 triangles after 50% is finer: "));
    CHECK_NOTHROW(check_order(parse_max_errors("0.1%,1%"), 1000));
  }
  TEST_CASE("caps are one for all levels or one for each") {
    auto targets = parse_lods("50%,25%,10%");
    CHECK(targets[0].max_influences == LevelTarget{}.max_influences);
    set_max_influences(targets, "2");
    CHECK(targets[2].max_influences == 2);
    set_max_influences(targets, "4,2,1");
    CHECK(targets[0].max_influences == 4);
    CHECK(targets[2].max_influences == 1);
    const auto caps = [&](const char* list) { return refusal([&] { set_max_influences(targets, list); }); };
    CHECK(caps("4,2") == "--max-influences: 2 caps for 3 levels: give one for all or one for each");
    CHECK(caps("9") == "--max-influences: '9' is out of range: give 1 to 8");
    CHECK(caps("0") == "--max-influences: '0' is out of range: give 1 to 8");
    CHECK(caps("many") == "--max-influences: 'many' is not a whole number in range: give 1 to 8");
  }
  TEST_CASE("joints are one number for all levels or one for each and do not return") {
    auto targets = parse_lods("50%,25%,10%");
    CHECK_FALSE(targets[0].max_joints);
    set_max_joints(targets, "30");
    CHECK(targets[2].max_joints == 30);
    set_max_joints(targets, "40,40,20");
    CHECK(targets[0].max_joints == 40);
    CHECK(targets[2].max_joints == 20);
    CHECK(text(targets[2]) == "10% and 20 joints");
    const auto joints = [&](const char* list) { return refusal([&] { set_max_joints(targets, list); }); };
    CHECK(joints("40,20") == "--joints-per-lod: 2 numbers for 3 levels: give one for all or one for each");
    CHECK(joints("40,20,30") ==
          "--joints-per-lod: '30' after 20 would let joints return: list the levels from fine to coarse");
    CHECK(joints("0") == "--joints-per-lod: '0' is out of range: give 1 to 2147483647");
    CHECK(joints("all").starts_with("--joints-per-lod: 'all' is not a whole number"));
  }
  TEST_CASE("what joints may cost is a share of the diagonal that grows from level to level") {
    auto targets = parse_lods("50%,25%");
    set_joint_errors(targets, "0.1%");
    CHECK(targets[1].joint_error == 0.001);
    set_joint_errors(targets, "0.1%,0.5%");
    CHECK(targets[1].joint_error == 0.005);
    CHECK_FALSE(targets[1].max_joints);
    CHECK(text(targets[1]) == "25% and joint error 0.5%");
    const auto errors = [&](const char* list) { return refusal([&] { set_joint_errors(targets, list); }); };
    CHECK(errors("0.1%,0.2%,0.3%") ==
          "--joint-error: 3 errors for 2 levels: give one for all or one for each");
    CHECK(errors("0.5%,0.1%").starts_with("--joint-error: '0.1%' after 0.5% would let joints return: "));
    CHECK(errors("0.1") == "--joint-error: '0.1' is no percentage of the diagonal: write 0.2%");
    CHECK(errors("0%").starts_with("--joint-error: '0%' is out of range: "));
  }
  TEST_CASE("somebody who forgot the percent signs is told") {
    CHECK(doubt(parse_lods("50,25,10"), 20000) ==
          "--lods: 50 is a number of triangles: for a share of the source's write 50%");
    CHECK_FALSE(doubt(parse_lods("50%,25"), 20000));
    CHECK_FALSE(doubt(parse_lods("5000,50"), 20000));
    CHECK_FALSE(doubt(parse_lods("50,25"), 600));
  }
}

}  // namespace skinlod
