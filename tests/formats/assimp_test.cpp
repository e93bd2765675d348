// SPDX-License-Identifier: MIT
#include "formats/assimp.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "formats/archive.h"
#include "pipeline/error.h"
#include "tests/formats/scratch.h"
#include "tests/formats/small_files.h"

namespace skinlod {
namespace {

/// What an import of the text fails with: its fault and message.
std::pair<int, std::string> failure(const std::string& name, const std::string& text) {
  const Scratch scratch;
  try {
    import_assimp(scratch.file(name, text));
  } catch (const Error& e) {
    return {int(e.fault), e.what()};
  }
  return {0, ""};
}

Imported import_text(const std::string& name, const std::string& text) {
  const Scratch scratch;
  return import_assimp(scratch.file(name, text));
}

const Node& node_of(const Character& character, int joint) {
  return character.skeleton.nodes[character.skeleton.joints[joint].node];
}

int find_node(const Character& character, const std::string& name) {
  const auto& nodes = character.skeleton.nodes;
  const auto node = std::find_if(nodes.begin(), nodes.end(), [&](const Node& n) { return n.name == name; });
  return node == nodes.end() ? -1 : int(node - nodes.begin());
}

struct Extent {
  Vec3 low = Vec3::Constant(1e9), high = Vec3::Constant(-1e9);
  explicit Extent(const Surface& surface) {
    for (const Vec3& x : surface.position) low = low.cwiseMin(x), high = high.cwiseMax(x);
  }
};

/// What a reader of the file's README would count.
struct Counts {
  int triangles, joints, influences, clips;
  double seconds;
};

Counts counts(const Character& character) {
  std::set<int> joints;
  size_t most = 0;
  double seconds = 0;
  for (const Influences& influences : character.surface.influences) {
    most = std::max(most, influences.size());
    if (influences.size() == 1 && influences[0].weight == 1) continue;  // may be a rigid part
    for (const Influence& influence : influences) joints.insert(influence.joint);
  }
  for (const Influences& influences : character.surface.influences) {
    for (const Influence& influence : influences) {
      const bool bound = node_of(character, influence.joint).name.find("high") == std::string::npos;
      if (bound) joints.insert(influence.joint);  // slime: its rigid twin is "...Body_high"
    }
  }
  for (const Clip& clip : character.clips) seconds += clip.duration();
  return {triangle_count(character.surface), int(joints.size()), int(most), int(character.clips.size()),
          seconds};
}

}  // namespace

TEST_SUITE("assimp") {
  TEST_CASE("a skinned quad of MD5 comes in with its weights") {
    const Imported imported = import_text("small.md5mesh", kSmallMd5);
    const Character& character = imported.character;
    CHECK(triangle_count(character.surface) == 2);
    CHECK(character.skeleton.joints.size() == 2);
    CHECK(find_node(character, "tip") > find_node(character, "root"));
    const bool shared = std::any_of(
        character.surface.influences.begin(), character.surface.influences.end(),
        [](const Influences& i) { return i.size() == 2 && i[0].weight == 0.5 && i[1].weight == 0.5; });
    CHECK(shared);
    REQUIRE(imported.files_read.size() == 1);
    CHECK(imported.files_read[0].ends_with("small.md5mesh"));
  }

  TEST_CASE("Collada comes out in metres with Y up and polygons kept and props where they stand") {
    const Character character = import_text("small.dae", kSmallCollada).character;
    const Surface& surface = character.surface;
    REQUIRE(character.parts.size() == 3);
    CHECK(surface.face_count() == 3);  // a quad and two triangles
    CHECK(triangle_count(surface) == 4);
    CHECK(character.skeleton.joints.size() == 4);  // hip, knee and one for each prop
    const Extent box(surface);
    CHECK((box.low - Vec3(-1, 0, 0)).norm() < 1e-6);
    CHECK((box.high - Vec3(0.5, 2.1, 0)).norm() < 1e-6);

    const auto quad = std::find_if(surface.wedges.begin(), surface.wedges.end(), [&](const Wedge& w) {
      return character.parts[w.part].node == find_node(character, "body");
    });
    REQUIRE(quad != surface.wedges.end());
    const int fourth = quad->vertex + 3;
    CHECK((surface.position[fourth] - Vec3(0, 2, 0)).norm() < 1e-6);
    CHECK(surface.influences[fourth].size() == 2);
    CHECK(surface.attributes(fourth, surface.layout.uv_at(0) + 1) == 0.25);  // v grows down
    CHECK(surface.layout.uv_sets == 1);
    CHECK(!character.parts[surface.wedges.back().part].has.uv_sets);

    REQUIRE(character.clips.size() == 1);
    CHECK(character.clips[0].duration() == doctest::Approx(1));
    const auto& channels = character.clips[0].channels;
    const auto moved = std::find_if(channels.begin(), channels.end(), [&](const Channel& c) {
      return c.node == find_node(character, "knee") && c.path == Path::Translation;
    });
    REQUIRE(moved != channels.end());
    CHECK((moved->values.row(0) - Eigen::RowVector3d(0, 0, 100)).norm() < 1e-4);
    CHECK((moved->values.bottomRows(1) - Eigen::RowVector3d(0, 0, 150)).norm() < 1e-4);
  }

  TEST_CASE("nodes of Collada have their names and where two share one all have their ids") {
    std::string named = kSmallCollada;
    for (const char* id : {"hip", "knee", "hung", "body", "stood"})
      named = edited(named, "<node id=\"" + std::string(id),
                     "<node name=\"the " + std::string(id) + "\" id=\"" + id);
    const auto check = [](const Character& character, const std::string& before) {
      for (const char* name : {"hip", "knee", "hung", "body", "stood"}) {
        CAPTURE(name);
        CHECK(find_node(character, before + name) >= 0);
      }
      CHECK(character.skeleton.joints.size() == 4);
      REQUIRE(character.clips.size() == 1);
      for (const Channel& channel : character.clips[0].channels)
        CHECK(channel.node == find_node(character, before + "knee"));
    };
    check(import_text("named.dae", named).character, "the ");
    check(import_text("twins.dae", edited(named, "the stood", "the hung")).character, "");
    check(import_text("half.dae", edited(named, "name=\"the stood\"", "")).character, "");
  }

  TEST_CASE("a key of Ogre moves a bone from where it rests and is not turned by it") {
    const Scratch scratch;
    const std::string quarter = "<position x=\"0\" y=\"1\" z=\"0\"/><rotation angle=\"";
    const auto mesh = scratch.file("small.mesh.xml", text_of("tests/fuzz/corpus/assimp/small.mesh.xml"));
    scratch.file("small.skeleton.xml", edited(text_of("tests/fuzz/corpus/assimp/small.skeleton.xml"),
                                              quarter + "0\"", quarter + "1.57079633\""));
    const Character character = import_assimp(mesh).character;
    REQUIRE(character.clips.size() == 1);
    int moves = 0;
    for (const Channel& channel : character.clips[0].channels) {
      if (channel.path != Path::Translation) continue;
      ++moves;
      CHECK((channel.values.row(0) - Eigen::RowVector3d(0, 1, 0)).norm() < 1e-6);
      CHECK((channel.values.row(1) - Eigen::RowVector3d(0, 1.5, 0)).norm() < 1e-6);
    }
    CHECK(moves == 1);
  }

  TEST_CASE("a mesh node with the name of a joint does not take its place") {
    const Imported imported = import_text("clash.x", kClashingX);
    const Character& character = imported.character;
    REQUIRE(character.skeleton.joints.size() == 1);
    CHECK(node_of(character, 0).rest.translation.isApprox(Vec3(0, 2, 0)));  // not the mesh's, at x = 5
    REQUIRE(imported.warnings.size() == 1);
    CHECK(imported.warnings[0].code == WarningCode::JointNameClash);
    CHECK(imported.warnings[0].part == "Bone");
    REQUIRE(character.clips.size() == 1);
    for (const Channel& channel : character.clips[0].channels) {
      CHECK(channel.node == character.skeleton.joints[0].node);
    }
    CHECK(character.clips[0].duration() == 1);  // 4800 ticks a second where X is silent
  }

  TEST_CASE("only clips are read where only clips are needed") {
    const Scratch scratch;
    const std::string path = scratch.file("small.dae", kSmallCollada);
    const Character clips = import_assimp(path, Need::ClipsOnly).character;
    CHECK(clips.surface.position.empty());
    CHECK(clips.clips.size() == 1);
    const std::string bare = edited(kSmallCollada, "<instance_controller url=\"#skin\">", "<never>");
    CHECK(import_assimp(scratch.file("x.dae", edited(bare, "</instance_controller>", "</never>")),
                        Need::ClipsOnly)
              .character.clips.size() == 1);
  }

  TEST_CASE("a file without skin or faces or bytes is bad input and says so") {
    const auto [obj, no_skin] = failure("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    CHECK(obj == int(Fault::Input));
    CHECK(no_skin.find("plain.obj: no skin: ") != std::string::npos);
    const auto [points, no_faces] = failure("points.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
    CHECK(points == int(Fault::Input));
    CHECK(no_faces.find("points.obj: no faces: ") != std::string::npos);
    const auto [empty, nothing] = failure("empty.fbx", "");
    CHECK(empty == int(Fault::Input));
    CHECK(nothing.find("empty.fbx: is empty: ") != std::string::npos);
    CHECK(failure("noise.fbx", "what is this").first == int(Fault::Input));
    try {
      import_assimp("no/such.fbx");
      FAIL("a file that is not there was read");
    } catch (const Error& e) {
      CHECK(e.fault == Fault::Access);
    }
  }

  TEST_CASE("files that kill Assimp are bad input and nothing more") {
    // Heap corruption, and a read far out of bounds: either ends the process that reads them.
    using Edit = std::pair<std::string, std::string>;
    for (const Edit& edit :
         {Edit("vert 2 (", "vert 7 ("), Edit("vert 3 ( 0 1 ) 4", "vert 3 ( 0 1 ) 9999999")}) {
      CAPTURE(edit.second);
      const std::string text = edited(kSmallMd5, edit.first, edit.second);
      REQUIRE(!text.empty());
      const auto [fault, message] = failure("bad.md5mesh", text);
      CHECK(fault == int(Fault::Input));
      CHECK(message.find("bad.md5mesh: its reader ") != std::string::npos);
    }
  }

  TEST_CASE("every prefix of a file is read or refused") {
    for (size_t size = 0; size < kSmallMd5.size(); size += 61) {
      CAPTURE(size);
      const int fault = failure("cut.md5mesh", kSmallMd5.substr(0, size)).first;
      CHECK((fault == 0 || fault == int(Fault::Input)));
    }
    for (size_t size = 0; size < kSmallCollada.size(); size += 1201) {
      CAPTURE(size);
      CHECK(failure("cut.dae", kSmallCollada.substr(0, size)).first == int(Fault::Input));
    }
  }

  TEST_CASE("shared characters come in with the counts of their README") {
    struct Expected {
      const char* file;
      Counts counts;
      double tallest;  // metres or the file's own unit
    };
    for (const Expected& expected : {
             Expected{"wuson_x/Testwuson.X", {3732, 37, 4, 3, 4.6}, 1.5},
             Expected{"minetest_sam/sam.b3d", {84, 6, 1, 1, 3.7}, 17},
             Expected{"ogre_ninja/ninja.mesh", {1008, 21, 1, 20, 23.2}, 191.8},
             Expected{"ogre_ninja/ninja.mesh.xml", {1008, 21, 1, 20, 23.2}, 191.8},
             Expected{"slime_fbx_ascii/maya_slime_7500_ascii.fbx", {4880, 3, 3, 1, 2.0}, 0.64},
             Expected{"quaternius_dragon/YellowDragon.fbx", {1592, 17, 6, 8, 9.0}, 1.6},
             Expected{"cesium_man/CesiumMan.dae", {4672, 19, 8, 1, 2.0}, 1.5},
             Expected{"arnaud/arnaud.fbx", {6670, 53, 5, 0, 0.0}, 1.83},
             Expected{"rocketbox_female/Female_Adult_01_facial.fbx", {8732, 80, 4, 1, 0.0}, 1.74},
         }) {
      CAPTURE(expected.file);
      const auto path = content(expected.file);
      if (!path) {
        MESSAGE("SKIPPED: no shared content: set SKINLOD_CONTENT");
        return;
      }
      const Imported imported = import_assimp(*path);
      const Counts got = counts(imported.character);
      CHECK(got.triangles == expected.counts.triangles);
      CHECK(got.joints == expected.counts.joints);
      CHECK(got.influences == expected.counts.influences);
      CHECK(got.clips == expected.counts.clips);
      CHECK(got.seconds == doctest::Approx(expected.counts.seconds).epsilon(0.02));
      CHECK(Extent(imported.character.surface).high.y() == doctest::Approx(expected.tallest).epsilon(0.02));
      CHECK(imported.files_read.front() == *path);
    }
  }

  TEST_CASE("the ninja is the same from XML and from binary files") {
    const auto xml = content("ogre_ninja/ninja.mesh.xml"), binary = content("ogre_ninja/ninja.mesh");
    if (!xml || !binary) {
      MESSAGE("SKIPPED: no shared content: set SKINLOD_CONTENT");
      return;
    }
    const Character a = import_assimp(*xml).character, b = import_assimp(*binary).character;
    REQUIRE(a.surface.position.size() == b.surface.position.size());
    double worst = 0;
    for (size_t v = 0; v < a.surface.position.size(); ++v) {
      worst = std::max(worst, (a.surface.position[v] - b.surface.position[v]).norm());
      CHECK(a.surface.influences[v] == b.surface.influences[v]);
    }
    CHECK(worst < 1e-3);  // of 192 units
  }

  TEST_CASE("FBX is turned and scaled as its settings say") {
    const auto path = content("slime_fbx_ascii/maya_slime_7500_ascii.fbx");
    if (!path) {
      MESSAGE("SKIPPED: no shared content: set SKINLOD_CONTENT");
      return;
    }
    const Character as_it_is = import_assimp(*path).character;
    std::string text = text_of(*path);
    text = edited(text, R"("UpAxis", "int", "Integer", "",1)", R"("UpAxis", "int", "Integer", "",2)");
    text = edited(text, R"("FrontAxis", "int", "Integer", "",2)", R"("FrontAxis", "int", "Integer", "",1)");
    text = edited(text, R"("FrontAxisSign", "int", "Integer", "",1)",
                  R"("FrontAxisSign", "int", "Integer", "",-1)");
    text = edited(text, R"("UnitScaleFactor", "double", "Number", "",1)",
                  R"("UnitScaleFactor", "double", "Number", "",100)");
    REQUIRE(!text.empty());
    const Character turned = import_text("turned.fbx", text).character;
    const size_t count = as_it_is.surface.position.size();
    REQUIRE(turned.surface.position.size() == count);
    for (size_t v = 0; v < count; v += 97) {
      const Vec3 x = 100 * as_it_is.surface.position[v];
      CHECK((turned.surface.position[v] - Vec3(x.x(), x.z(), -x.y())).norm() < 1e-4);
    }
  }

  TEST_CASE("blend shapes are morphs of the node and their noise is left out") {
    const auto path = content("rocketbox_female/Female_Adult_01_facial.fbx");
    if (!path) {
      MESSAGE("SKIPPED: no shared content: set SKINLOD_CONTENT");
      return;
    }
    const Character character = import_assimp(*path).character;
    CHECK(character.morphs.size() == 175);
    CHECK(character.morphs.front().name == "AA_VI_00_Sil");
    CHECK(std::all_of(character.morphs.begin(), character.morphs.end(), [&](const Morph& m) {
      return m.node == character.morphs.front().node && m.weight == 0;
    }));
    size_t offsets = 0, useless = 0;
    for (const auto& morphs : character.surface.morphs) {
      for (const MorphOffset& offset : morphs) ++offsets, useless += offset.delta.norm() < 1e-7;
    }
    CHECK(offsets > 100'000);
    CHECK(useless == 0);
  }
}

TEST_SUITE("archive") {
  TEST_CASE("an import survives the way and comes out the same") {
    const Imported imported = import_text("small.dae", kSmallCollada);
    const std::vector<std::byte> bytes = to_bytes(imported);
    CHECK(to_bytes(from_bytes(bytes)) == bytes);
    CHECK(from_bytes(bytes).character.surface.attributes == imported.character.surface.attributes);
  }

  TEST_CASE("no prefix and no flipped byte of an archive does harm") {
    const std::vector<std::byte> bytes = to_bytes(import_text("clash.x", kClashingX));
    for (size_t size = 0; size < bytes.size(); ++size) {
      CHECK_THROWS_AS(from_bytes(std::span(bytes).first(size)), Error);
    }
    for (size_t i = 0; i < bytes.size(); ++i) {
      std::vector<std::byte> bad = bytes;
      bad[i] ^= std::byte(0xff);
      try {
        from_bytes(bad);
      } catch (const Error& e) {
        CHECK(e.fault == Fault::Input);
      }
    }
  }
}

}  // namespace skinlod
