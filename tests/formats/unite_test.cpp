// SPDX-License-Identifier: MIT
#include "formats/unite.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "formats/gltf.h"
#include "formats/slod.h"
#include "pipeline/cook.h"
#include "pipeline/error.h"
#include "pipeline/pack.h"
#include "pipeline/repair.h"
#include "tests/formats/gltf_sample.h"
#include "tests/formats/scratch.h"
#include "tests/shapes.h"
#include "tests/topology.h"

namespace skinlod {
namespace {

using Json = nlohmann::json;

constexpr double kCut = 2;
Imported lower() {
  return {.character = part_of(bending_tube(12, 12, 4), [](const Vec3& x) { return x.y() < kCut; }),
          .warnings = {},
          .files_read = {"lower.fbx"}};
}
Imported upper() {
  return {.character = part_of(bending_tube(12, 12, 4), [](const Vec3& x) { return x.y() > kCut; }),
          .warnings = {},
          .files_read = {"upper.fbx"}};
}

Imported united(Imported a, Imported b) {
  unite(a, std::move(b), "upper.fbx");
  return a;
}

std::string refused(Imported a, Imported b) {
  try {
    unite(a, std::move(b), "upper.fbx");
  } catch (const Error& e) {
    CHECK(e.fault == Fault::Input);
    return e.what();
  }
  return "";
}

Character mended(Character c) {
  repair(c), weld(c);
  return c;
}

// Every posed vertex of `a` is one of `b`, to within rounding, and the other way round.
void check_posed_alike(const Character& a, const Character& b, double time) {
  const auto x = pose_vertices(a.surface, sample(a.skeleton, a.clips[0], time));
  const auto y = pose_vertices(b.surface, sample(b.skeleton, b.clips[0], time));
  CHECK(x.size() == y.size());
  const auto all_near = [](const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
    return std::ranges::all_of(from, [&](const Vec3& p) {
      return std::ranges::any_of(to, [&](const Vec3& q) { return (p - q).norm() < 1e-9; });
    });
  };
  CHECK(all_near(x, y));
  CHECK(all_near(y, x));
}

Json json_of(const std::vector<std::byte>& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  const auto* const first = reinterpret_cast<const char*>(glb.data()) + 20;
  return Json::parse(first, first + length);
}

// The sample with its material in a texture: an image in the file that `picture` fills.
Imported textured(const std::string& name, unsigned char picture) {
  GltfFile file = sample_file();
  const unsigned char png[] = {0x89, 'P', 'N', 'G', picture};
  file.json["images"] = {{{"mimeType", "image/png"}, {"bufferView", file.view(png)}}};
  file.json["samplers"] = {{{"wrapS", 33071}}};
  file.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
  Json& material = file.json["materials"][0];
  material["name"] = name;
  material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  material["extensions"] = {{"KHR_materials_clearcoat", {{"clearcoatTexture", {{"index", 0}}}}}};
  file.json["extensionsUsed"] = {"KHR_materials_clearcoat"};
  const Scratch folder;
  return import_gltf(folder.file(name + ".glb", text(file.glb())));
}

}  // namespace

TEST_SUITE("unite") {
  TEST_CASE("a character cut in two files is whole again, and its cut one ring of vertices") {
    const Character whole = mended(bending_tube(12, 12, 4));
    const Imported both = united(lower(), upper());
    const Character joined = mended(both.character);
    CHECK(joined.surface.face_count() == whole.surface.face_count());
    CHECK(joined.skeleton.joints.size() == whole.skeleton.joints.size());
    CHECK(joined.skeleton.nodes.size() == whole.skeleton.nodes.size() + 1);  // a mesh node each
    CHECK(border_edges(joined.surface) == 0);
    CHECK(border_edges(mended(lower().character).surface) == 12);
    CHECK(joined.clips.size() == whole.clips.size());
    CHECK(joined.parts.size() == 2);
    CHECK(both.warnings.empty());
    CHECK(both.files_read == std::vector<std::string>{"lower.fbx", "upper.fbx"});
    for (const double time : {0.0, 0.4, 1.0}) check_posed_alike(joined, whole, time);
  }

  TEST_CASE("the second file may bind in another space and have its joints in another order") {
    Imported other = upper();
    Character& c = other.character;
    std::reverse(c.skeleton.joints.begin(), c.skeleton.joints.end());
    Affine change;  // a rest space of half the size, mirrored, elsewhere
    change << Vec3(-0.5, 0.5, 0.5).asDiagonal().toDenseMatrix(), Vec3(3, -2, 1);
    for (Joint& joint : c.skeleton.joints) joint.inverse_bind = compose(joint.inverse_bind, inverse(change));
    for (Vec3& x : c.surface.position) x = transform(change, x);
    for (Influences& influences : c.surface.influences) {
      for (Influence& i : influences) i.joint = 3 - i.joint;
    }
    for (int f = 0; f < c.surface.face_count(); ++f)
      std::swap(c.surface.corners[size_t(3 * f)], c.surface.corners[size_t(3 * f + 1)]);
    c.surface.attributes.col(0) *= -1;

    const Character joined = mended(united(lower(), std::move(other)).character);
    const Character whole = mended(bending_tube(12, 12, 4));
    CHECK(border_edges(joined.surface) == 0);
    CHECK(volume(joined.surface) == doctest::Approx(volume(whole.surface)));
    for (const double time : {0.0, 0.4}) check_posed_alike(joined, whole, time);
    for (size_t w = 0; w < joined.surface.wedges.size(); ++w) {
      const Vec3& x = joined.surface.position[size_t(joined.surface.wedges[w].vertex)];
      const Vec3 normal = joined.surface.attributes.row(Eigen::Index(w)).head<3>().transpose();
      CHECK(normal.dot(Vec3(x.x(), x.y() - 2, x.z())) > 0);  // outwards
    }
  }

  TEST_CASE("the second file may have fewer joints, and more") {
    Imported fewer = lower(), more = upper();
    fewer.character.skeleton.joints.pop_back();
    for (Influences& influences : fewer.character.surface.influences) {
      for (Influence& i : influences) i.joint = std::min(i.joint, 2);
    }
    more.character.skeleton.nodes.push_back({.name = "jaw", .parent = 3});
    more.character.skeleton.joints.push_back({.node = int(more.character.skeleton.nodes.size()) - 1});
    for (const auto& [a, b] : {std::pair(fewer, more), std::pair(more, fewer)}) {
      const Character joined = united(a, b).character;
      CHECK(joined.skeleton.joints.size() == 5);
      CHECK(std::ranges::count(joined.skeleton.nodes, "jaw", &Node::name) == 1);
    }
  }

  TEST_CASE("what is not one skeleton is refused with file and joint") {
    Imported other = upper();
    other.character.skeleton.nodes[2].parent = 0;
    CHECK(refused(lower(), other)
              .find("upper.fbx: joint '" + other.character.skeleton.nodes[2].name + "': hangs from '") == 0);
    other = upper();
    other.character.skeleton.nodes[1].rest.translation.y() += 0.01;
    CHECK(refused(lower(), other).find("rests elsewhere than in the files before it") != std::string::npos);
    other.character.skeleton.nodes[1].rest.translation.y() -= 0.01 - 1e-6;  // an exporter's rounding
    CHECK(refused(lower(), other) == "");
    for (Node& node : other.character.skeleton.nodes) node.name = "b_" + node.name;
    CHECK(refused(lower(), other).find("none of its joints is in the files before it") != std::string::npos);
  }

  TEST_CASE("attributes that one file lacks hold their defaults") {
    Imported bare = upper();
    Surface& s = bare.character.surface;
    s.layout = {.normal = true, .tangent = false, .uv_sets = 0, .colour_sets = 1};
    Rows rows(s.attributes.rows(), 7);
    rows << s.attributes.leftCols<3>(), Rows::Constant(rows.rows(), 4, 0.5);
    s.attributes = rows;
    bare.character.parts[0].has = s.layout;
    const Character joined = united(lower(), std::move(bare)).character;
    const AttributeLayout& layout = joined.surface.layout;
    CHECK(layout == AttributeLayout{.normal = true, .tangent = false, .uv_sets = 1, .colour_sets = 1});
    for (size_t w = 0; w < joined.surface.wedges.size(); ++w) {
      const auto row = joined.surface.attributes.row(Eigen::Index(w));
      const bool second = joined.surface.wedges[w].part == 1;
      CHECK(row[layout.colour_at(0)] == (second ? 0.5 : 1.0));
      if (second) CHECK(row[layout.uv_at(0)] == 0);
    }
  }

  TEST_CASE("of clips with one name the first is kept, and what only the second moves is a clip of its own") {
    Imported other = upper();
    Character& c = other.character;
    c.skeleton.nodes.push_back({.name = "jaw", .parent = 3});
    Channel jaw = c.clips[0].channels[0];
    jaw.node = int(c.skeleton.nodes.size()) - 1;
    c.clips[0].channels.push_back(jaw);
    Imported both = united(lower(), other);
    REQUIRE(both.character.clips.size() == 3);
    CHECK(both.warnings.empty());
    CHECK(both.character.clips[2].name == "bend (upper)");
    REQUIRE(both.character.clips[2].channels.size() == 1);
    CHECK(both.character.skeleton.nodes[size_t(both.character.clips[2].channels[0].node)].name == "jaw");

    other.character.clips[1].channels[0].values *= -1;
    both = united(lower(), other);
    REQUIRE(both.warnings.size() == 1);
    CHECK(both.warnings[0].code == WarningCode::ClipChannelsTwice);
    CHECK(both.warnings[0].count == 1);
  }

  TEST_CASE("materials come along with their textures and extensions, each once") {
    const auto glb = [](const Imported& whole) {
      Character c = mended(whole.character);
      return json_of(write_glb(c, c.surface, whole.document.get()));
    };
    Imported whole = textured("skin", 1);
    unite(whole, textured("cloth", 2), "cloth.glb");
    unite(whole, textured("skin", 1), "again.glb");
    CHECK(whole.character.materials.size() == 2);
    CHECK(whole.character.parts.size() == 6);
    const Json json = glb(whole);
    REQUIRE(json["materials"].size() == 2);
    CHECK(json["materials"][1]["name"] == "cloth");
    CHECK(json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"]["index"] == 1);
    CHECK(json["materials"][1]["extensions"]["KHR_materials_clearcoat"]["clearcoatTexture"]["index"] == 1);
    CHECK(json["textures"] == Json::parse(R"([{"source": 0, "sampler": 0}, {"source": 1, "sampler": 0}])"));
    CHECK(json["images"].size() == 2);
    CHECK(json["samplers"].size() == 1);
    CHECK(json["extensionsUsed"] == Json{"KHR_materials_clearcoat"});
    std::vector<int> shown;
    for (const Json& mesh : json["meshes"]) {
      for (const Json& primitive : mesh["primitives"]) shown.push_back(primitive.value("material", -1));
    }
    std::sort(shown.begin(), shown.end());
    CHECK(shown == std::vector<int>{-1, -1, -1, 0, 0, 1});

    // A file of another format adds what its character knows, and the document stays.
    Imported plain = textured("plain", 3);
    plain.document = nullptr;
    unite(whole, plain, "plain.fbx");
    CHECK(whole.character.materials.size() == 3);
    CHECK(glb(whole)["materials"][2]["name"] == "plain");
    CHECK(glb(whole)["images"].size() == 2);

    // Without a document at the front nothing keeps textures, and that is told.
    unite(plain, textured("skin", 1), "skin.glb");
    CHECK(plain.character.materials.size() == 2);
    REQUIRE(!plain.warnings.empty());
    CHECK(plain.warnings.back().code == WarningCode::MaterialPropertyLost);
  }

  TEST_CASE("what united files hold is written and read back") {
    Imported whole = textured("skin", 1);
    Imported other = textured("cloth", 2);
    for (Vec3& x : other.character.surface.position) x.z() -= 3;
    unite(whole, std::move(other), "cloth.glb");
    Character c = mended(whole.character);
    const auto bytes = write_glb(c, c.surface, whole.document.get());
    const Scratch folder;
    const auto* const first = reinterpret_cast<const char*>(bytes.data());
    const Imported back = import_gltf(folder.file("both.glb", {first, bytes.size()}));
    CHECK(back.character.skeleton.nodes.size() == c.skeleton.nodes.size());
    CHECK(back.character.parts.size() == 4);
    CHECK(back.character.morphs.size() == 2);
    CHECK(triangle_count(back.character.surface) == triangle_count(c.surface));
    for (const double time : {0.0, 0.3, 1.0}) {
      const auto a = pose_vertices(c.surface, sample(c.skeleton, c.clips[0], time));
      const auto b = pose_vertices(back.character.surface,
                                   sample(back.character.skeleton, back.character.clips[0], time));
      for (const Vec3& p : b)
        CHECK(std::ranges::any_of(a, [&](const Vec3& q) { return (p - q).norm() < 1e-5; }));
    }
  }
}

TEST_SUITE("modular") {
  // Our humanoid in two files, cut below its head.
  Imported cut(bool head) {
    Imported imported = import_gltf("content/humanoid.glb");
    const std::vector<Vec3>& position = imported.character.surface.position;
    double top = position[0].y(), bottom = top;
    for (const Vec3& x : position) top = std::max(top, x.y()), bottom = std::min(bottom, x.y());
    const double neck = bottom + 0.85 * (top - bottom);
    imported.character =
        part_of(std::move(imported.character), [&](const Vec3& x) { return (x.y() > neck) == head; });
    return imported;
  }

  Cooked cooked(Imported imported, Borders borders) {
    return cook(std::move(imported.character),
                {.poses = {.from_clips = 2, .range_of_motion = 1},
                 .chain = {.targets = {{.ratio = 0.25}, {.ratio = 0.08, .max_influences = 2}},
                           .borders = borders,
                           .measured = false}});
  }

  // The points on open borders that both surfaces have at rest, where `palette` takes them.
  using Points = std::set<std::array<float, 3>>;
  Points border(const Surface& surface, const Palette& palette) {
    const std::vector<char> on = locked_vertices(surface, Borders::Locked);
    const std::vector<Vec3> posed = pose_vertices(surface, palette);
    Points points;
    for (size_t v = 0; v < posed.size(); ++v) {
      if (on[v]) points.insert({float(posed[v].x()), float(posed[v].y()), float(posed[v].z())});
    }
    return points;
  }
  Points common(const Points& a, const Points& b) {
    Points both;
    std::ranges::set_intersection(a, b, std::inserter(both, both.end()));
    return both;
  }

  TEST_CASE("head and body cooked together have no open border between them in any level, packed or not") {
    Imported whole = cut(false);
    unite(whole, cut(true), "head.glb");
    const int open = border_edges(mended(import_gltf("content/humanoid.glb").character).surface);
    const Cooked both = cooked(std::move(whole), Borders::Free);
    CHECK(border_edges(both.character.surface) == open);
    const auto open_in = [](const Imported& part) { return border_edges(mended(part.character).surface); };
    CHECK(open_in(cut(false)) + open_in(cut(true)) > open);
    const SlodFile file = read_slod(pack(both.character, both.chain.levels), "packed");
    for (size_t l = 0; l < both.chain.levels.size(); ++l) {
      CHECK(border_edges(both.chain.levels[l].surface) <= open);
      CHECK(border_edges(file.levels[l].surface) <= open);  // whose vertices are one where all bits are
    }
  }

  TEST_CASE("head and body cooked apart meet in every level and pose where their borders are locked") {
    const Cooked body = cooked(cut(false), Borders::Locked), head = cooked(cut(true), Borders::Locked);
    const Cooked free_body = cooked(cut(false), Borders::Free), free_head = cooked(cut(true), Borders::Free);
    for (const Pose& pose : {body.poses.examples.front(), body.poses.examples.back()}) {
      const auto seam = [&](const Cooked& a, const Cooked& b, size_t l) {
        return common(border(a.chain.levels[l].surface, pose.palette),
                      border(b.chain.levels[l].surface, pose.palette))
            .size();
      };
      const size_t points = seam(body, head, 0);
      CHECK(points > 20);
      CHECK(seam(body, head, 1) == points);
      CHECK(seam(body, head, 2) == points);
      CHECK(seam(free_body, free_head, 2) < points / 2);
    }
  }
}

}  // namespace skinlod
