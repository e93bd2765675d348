// SPDX-License-Identifier: MIT
#include "formats/import.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "formats/assimp.h"
#include "formats/import_any.h"
#include "pipeline/error.h"
#include "tests/formats/gltf_sample.h"
#include "tests/formats/scratch.h"
#include "tests/formats/small_files.h"

namespace skinlod {
namespace {

template <class Action>
Error error_of(Action action) {
  try {
    action();
  } catch (const Error& e) {
    return e;
  }
  return {Fault::Ours, "no error"};
}

bool says(const Error& error, const char* words) {
  return std::string(error.what()).find(words) != std::string::npos;
}

std::int64_t count_of(const Warnings& warnings, WarningCode code) {
  std::int64_t count = 0;
  for (const Warning& warning : warnings) count += warning.code == code ? warning.count : 0;
  return count;
}

/// The skeleton as another program would have exported it.
Skeleton rescaled(Skeleton skeleton, double factor, const std::string& prefix = "") {
  for (Node& node : skeleton.nodes) node.rest.translation *= factor, node.name = prefix + node.name;
  return skeleton;
}

/// Joints of the skeleton that a clip moves.
int joints_moved(const BoundClips& bound, const Skeleton& skeleton) {
  std::set<int> moved, joints;
  for (const Clip& clip : bound.clips) {
    for (const Channel& channel : clip.channels) moved.insert(channel.node);
  }
  for (const Joint& joint : skeleton.joints) joints.insert(joint.node);
  return int(std::count_if(joints.begin(), joints.end(), [&](int n) { return moved.count(n) > 0; }));
}

}  // namespace

TEST_SUITE("import") {
  TEST_CASE("a character has the name of its file") {
    const Scratch scratch;
    CHECK(import_character(scratch.file("small.dae", kSmallCollada)).character.name == "small");
    CHECK(stem("a/ninja.mesh.xml") == "ninja");
    CHECK(stem("a.b/f_idle.max.fbx") == "f_idle.max");
  }

  TEST_CASE("what cannot be a character is refused with the reason") {
    const Scratch scratch;
    const Error unknown = error_of([&] { import_character(scratch.file("notes.txt", "hello")); });
    CHECK(unknown.fault == Fault::Input);
    CHECK(says(unknown, ".fbx"));
    CHECK(says(unknown, ".glb"));
    const Error cooked = error_of([&] { import_character(scratch.file("hero.slod", "SLOD")); });
    CHECK(cooked.fault == Fault::Input);
    CHECK(says(cooked, "is cooked already"));
    CHECK(error_of([&] { import_character(scratch.file("absent.fbx")); }).fault == Fault::Access);
    CHECK(error_of([&] { import_character(scratch.file("")); }).fault == Fault::Access);
    CHECK(error_of([&] { import_character("-"); }).fault == Fault::Usage);
    CHECK(error_of([&] { import_character(scratch.file("empty.dae", "")); }).fault == Fault::Input);
  }

  TEST_CASE("every format is listed once and ours and glTF stand first") {
    const std::vector<Format> all = formats();
    REQUIRE(all.size() > 3);
    CHECK(all[0].extensions == std::vector<std::string>{"slod"});
    CHECK(all[1].extensions.front() == "glb");
    std::set<std::string> seen;
    for (const Format& format : all) {
      CHECK((format.reads || format.writes));
      for (const std::string& extension : format.extensions) CHECK(seen.insert(extension).second);
      const bool assimps = format.reads && !format.name.starts_with("glTF");
      for (const std::string& extension : format.extensions) CHECK((!assimps || assimp_reads(extension)));
    }
  }

  TEST_CASE("clips bind by name with and without a namespace") {
    const Scratch scratch;
    const std::string path = scratch.file("move.dae", kSmallCollada);
    const Skeleton plain = import_assimp(path).character.skeleton;
    for (const char* prefix : {"", "mixamorig:", "Armature|"}) {
      const BoundClips bound = import_clips(path, rescaled(plain, 1, prefix));
      CHECK(bound.channels > 0);
      CHECK(bound.bound == bound.channels);
      REQUIRE(bound.clips.size() == 1);
      CHECK(bound.clips[0].name == "move");
      CHECK(bound.warnings.empty());
      CHECK(bound.files_read == std::vector<std::string>{path});
    }
  }

  TEST_CASE("clips of another skeleton or none are refused") {
    const Scratch scratch;
    const std::string path = scratch.file("move.dae", kSmallCollada);
    Skeleton other;
    other.nodes = {{"wheel"}, {"axle", 0}};
    const Error stranger = error_of([&] { import_clips(path, other); });
    CHECK(stranger.fault == Fault::Input);
    CHECK(says(stranger, "none of its"));
    const Error still = error_of([&] { import_clips(scratch.file("still.md5mesh", kSmallMd5), other); });
    CHECK(still.fault == Fault::Input);
    CHECK(says(still, "no clip"));
  }

  TEST_CASE("nodes without names are not of one name") {
    const Scratch scratch;
    GltfFile nameless = sample_file();
    for (nlohmann::json& node : nameless.json["nodes"]) node["name"] = "";
    const std::string path = scratch.file("nameless.glb", text(nameless.glb()));
    const Skeleton unnamed = import_character(path).character.skeleton;
    const std::string named = scratch.file("named.glb", text(sample_file().glb()));
    const Skeleton skeleton = import_character(named).character.skeleton;
    CHECK(says(error_of([&] { import_clips(path, unnamed); }), ": its nodes have no names: "));
    CHECK(says(error_of([&] { import_clips(path, skeleton); }), ": its nodes have no names: "));
    CHECK(says(error_of([&] { import_clips(named, unnamed); }), ": the character's nodes have no names: "));

    nameless.json["nodes"][1]["name"] = "hip";
    const BoundClips bound = import_clips(scratch.file("hip.glb", text(nameless.glb())), skeleton);
    CHECK(bound.bound == 1);
    CHECK(bound.clips[0].channels[0].node == 1);
  }

  TEST_CASE("clip files of shared characters move every joint") {
    struct Expected {
      const char *character, *clips;
      int joints;
      double seconds;
    };
    for (const Expected& expected : {
             Expected{"arnaud/arnaud.fbx", "arnaud/run.fbx", 53, 0.667},
             Expected{"arnaud/arnaud.fbx", "arnaud/walk.fbx", 53, 1.333},
             Expected{"arnaud/arnaud.fbx", "arnaud/crossarms.fbx", 53, 8.6},
             Expected{"rocketbox_female/Female_Adult_01_facial.fbx",
                      "rocketbox_female/f_idle_neutral_01.max.fbx", 80, 15.5},
         }) {
      CAPTURE(expected.clips);
      const auto character = content(expected.character), clips = content(expected.clips);
      if (!character || !clips) {
        MESSAGE("SKIPPED: no shared content: set SKINLOD_CONTENT");
        return;
      }
      const Skeleton skeleton = import_character(*character).character.skeleton;
      const BoundClips bound = import_clips(*clips, skeleton);
      REQUIRE(bound.clips.size() == 1);
      CHECK(bound.clips[0].name == stem(*clips));
      CHECK(bound.clips[0].duration() == doctest::Approx(expected.seconds).epsilon(0.01));
      CHECK(joints_moved(bound, skeleton) == expected.joints);
      CHECK(bound.bound < bound.channels);  // cameras, footsteps
      CHECK(count_of(bound.warnings, WarningCode::ClipChannelsUnbound) == bound.channels - bound.bound);
      CHECK(count_of(bound.warnings, WarningCode::ClipUnitsScaled) == 0);
    }
  }

  TEST_CASE("translations of a clip in another unit are scaled and that is said") {
    const auto character = content("arnaud/arnaud.fbx"), clips = content("arnaud/run.fbx");
    if (!character || !clips) {
      MESSAGE("SKIPPED: no shared content: set SKINLOD_CONTENT");
      return;
    }
    const Skeleton metres = import_character(*character).character.skeleton;
    const BoundClips same = import_clips(*clips, metres);
    const BoundClips scaled = import_clips(*clips, rescaled(metres, 100, "rig:"));
    CHECK(count_of(scaled.warnings, WarningCode::ClipUnitsScaled) == 1);
    REQUIRE(scaled.bound == same.bound);
    for (size_t c = 0; c < same.clips[0].channels.size(); ++c) {
      const Channel &a = same.clips[0].channels[c], &b = scaled.clips[0].channels[c];
      const double factor = a.path == Path::Translation ? 100 : 1;
      CHECK(b.values.isApprox(factor * a.values, 1e-4));
    }
  }

  TEST_CASE("several clips of a file are told apart by their names") {
    const auto path = content("wuson_x/Testwuson.X");
    if (!path) {
      MESSAGE("SKIPPED: no shared content: set SKINLOD_CONTENT");
      return;
    }
    const BoundClips bound = import_clips(*path, import_character(*path).character.skeleton);
    REQUIRE(bound.clips.size() == 3);
    CHECK(bound.clips[0].name == "Testwuson:Wuson_Run");
    CHECK(bound.bound == bound.channels);
  }
}

}  // namespace skinlod
