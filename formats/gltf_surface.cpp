// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cstring>
#include <map>

#include "formats/gltf_accessor.h"
#include "formats/gltf_read.h"
#include "formats/gltf_space.h"

namespace skinlod {
namespace {

// No character comes near.
constexpr size_t kMostParts = size_t(1) << 12;
constexpr size_t kMostSkins = size_t(1) << 10;
constexpr size_t kMostVertices = size_t(1) << 23;
constexpr size_t kMostMorphs = size_t(1) << 14;
constexpr size_t kMostZeroOffsets = size_t(1) << 28;  // they take time and no memory
constexpr int kMostSets = 8;                          // of influences, coordinates, colours

// A primitive at a node, on its way to be a part.
struct Source {
  const tinygltf::Primitive* primitive;
  const BoundSkin* bound;
  bool is_skinned;
  std::string accessors_of;  // "mesh 3: primitive 1", for messages
  int first_morph;
};

int attribute(const tinygltf::Primitive& primitive, const std::string& name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? -1 : found->second;
}

// How many attributes NAME_0, NAME_1, ... there are.
int set_count(const tinygltf::Primitive& primitive, const char* name) {
  int sets = 0;
  while (attribute(primitive, name + std::to_string(sets)) >= 0) ++sets;
  return sets;
}

AttributeLayout layout_of(const tinygltf::Primitive& primitive) {
  return {.normal = attribute(primitive, "NORMAL") >= 0,
          .tangent = attribute(primitive, "TANGENT") >= 0,
          .uv_sets = set_count(primitive, "TEXCOORD_"),
          .colour_sets = set_count(primitive, "COLOR_")};
}

bool is_triangles(const tinygltf::Primitive& primitive) {
  return primitive.mode == TINYGLTF_MODE_TRIANGLES || primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
         primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

// Reads one attribute of a primitive that has `count` vertices.
Rows read_attribute(const GltfDocument& doc, const Source& source, int accessor, Legal legal,
                    std::initializer_list<int> types, size_t count) {
  Rows rows = read_rows(doc, accessor, legal, types);
  if (size_t(rows.rows()) != count) {
    doc.fail(source.accessors_of, "accessor " + std::to_string(accessor) + " has " +
                                      std::to_string(rows.rows()) + " elements for " + std::to_string(count) +
                                      " vertices");
  }
  return rows;
}

// Sets of four influences each, sorted by joint and each joint once, but for weights of both signs: their sum
// would hide the negative ones. Joints that are not in the skin become joint -1. `repair` counts and mends
// both.
std::vector<Influences> read_influences(const GltfDocument& doc, const Source& source, size_t count) {
  const tinygltf::Primitive& primitive = *source.primitive;
  if (!source.is_skinned) return std::vector<Influences>(count, {{source.bound->joint[0], 1.0}});
  const int sets = set_count(primitive, "JOINTS_");
  if (sets != set_count(primitive, "WEIGHTS_"))
    doc.fail(source.accessors_of, "has not as many JOINTS as WEIGHTS");
  std::vector<Influences> influences(count);
  for (int set = 0; set < sets; ++set) {
    const std::string suffix = std::to_string(set);
    const auto joints =
        read_integers(doc, attribute(primitive, "JOINTS_" + suffix), Legal::Joints, TINYGLTF_TYPE_VEC4);
    const Rows weights = read_attribute(doc, source, attribute(primitive, "WEIGHTS_" + suffix),
                                        Legal::Weights, {TINYGLTF_TYPE_VEC4}, count);
    if (joints.size() != 4 * count)
      doc.fail(source.accessors_of, "JOINTS_" + suffix + " has not one element per vertex");
    for (size_t i = 0; i < joints.size(); ++i) {
      const double weight = weights.data()[i];
      if (weight == 0) continue;
      const bool known = joints[i] < source.bound->joint.size();
      const int joint = known ? source.bound->joint[joints[i]] : -1;
      Influences& its = influences[i / 4];
      const auto place =
          std::find_if(its.begin(), its.end(), [&](const Influence& w) { return w.joint >= joint; });
      if (place != its.end() && place->joint == joint && (place->weight < 0) == (weight < 0)) {
        place->weight += weight;
      } else {
        its.insert(place, {joint, weight});
      }
    }
  }
  return influences;
}

// The part's rows of the attribute table.
Rows read_attributes(const GltfDocument& doc, const Source& source, const ChangeOfSpace& to_rest,
                     const AttributeLayout& has, const AttributeLayout& layout, size_t count) {
  const tinygltf::Primitive& primitive = *source.primitive;
  Rows rows = default_attributes(layout).replicate(Eigen::Index(count), 1);
  const auto read = [&](const std::string& name, Legal legal, std::initializer_list<int> types) {
    return read_attribute(doc, source, attribute(primitive, name), legal, types, count);
  };
  if (has.normal) {
    const Rows normals = read("NORMAL", Legal::Direction, {TINYGLTF_TYPE_VEC3});
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      rows.row(i).segment<3>(layout.normal_at()) =
          unit(to_rest.normal * normals.row(i).transpose()).transpose();
    }
  }
  if (has.tangent) {
    const Rows tangents = read("TANGENT", Legal::Direction, {TINYGLTF_TYPE_VEC4});
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      const Vec3 along = to_rest.along * tangents.row(i).head<3>().transpose();
      rows.row(i).segment<3>(layout.tangent_at()) = unit(along).transpose();
      rows(i, layout.tangent_at() + 3) = to_rest.mirrors ? -tangents(i, 3) : tangents(i, 3);
    }
  }
  for (int set = 0; set < has.uv_sets; ++set) {
    rows.middleCols<2>(layout.uv_at(set)) =
        read("TEXCOORD_" + std::to_string(set), Legal::Coordinate, {TINYGLTF_TYPE_VEC2});
  }
  for (int set = 0; set < has.colour_sets; ++set) {
    const Rows colours =
        read("COLOR_" + std::to_string(set), Legal::Colour, {TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4});
    rows.middleCols(layout.colour_at(set), colours.cols()) = colours;
  }
  return rows;
}

Rows stacked(const std::vector<Rows>& tables, Eigen::Index columns) {
  Eigen::Index rows = 0;
  for (const Rows& table : tables) rows += table.rows();
  Rows all(rows, columns);
  rows = 0;
  for (const Rows& table : tables) all.middleRows(rows, table.rows()) = table, rows += table.rows();
  return all;
}

// Adds the offsets of one kind, POSITION or NORMAL, of all the primitive's targets to `morphs` from `first`
// on.
void read_offsets(const GltfDocument& doc, const Source& source, const char* kind, const Mat3& to_rest,
                  size_t first, size_t count, std::vector<MorphOffsets>& morphs) {
  const auto& targets = source.primitive->targets;
  for (size_t t = 0; t < targets.size(); ++t) {
    const auto found = targets[t].find(kind);
    if (found == targets[t].end()) continue;
    const Legal legal = kind == std::string_view("NORMAL") ? Legal::Direction : Legal::Position;
    const Rows offsets = read_attribute(doc, source, found->second, legal, {TINYGLTF_TYPE_VEC3}, count);
    for (size_t i = 0; i < count; ++i) {
      const Vec3 offset = offsets.row(Eigen::Index(i)).transpose();
      if (offset != Vec3::Zero())
        morphs[first + i].push_back({source.first_morph + int(t), to_rest * offset});
    }
  }
}

// The corners of the primitive's triangles, counter-clockwise, by vertex of the primitive.
std::vector<std::array<std::uint32_t, 3>> triangles(const tinygltf::Primitive& primitive,
                                                    const std::vector<std::uint32_t>& corner) {
  std::vector<std::array<std::uint32_t, 3>> out;
  if (primitive.mode == TINYGLTF_MODE_TRIANGLES) {
    for (size_t i = 0; i + 2 < corner.size(); i += 3)
      out.push_back({corner[i], corner[i + 1], corner[i + 2]});
  } else if (primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    for (size_t i = 0; i + 2 < corner.size(); ++i) {
      const std::array face{corner[i], corner[i + 1 + i % 2], corner[i + 2 - i % 2]};
      // a strip turns corners by repeating them: no faces, and no fault
      if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) out.push_back(face);
    }
  } else {
    for (size_t i = 0; i + 2 < corner.size(); ++i) out.push_back({corner[i + 1], corner[i + 2], corner[0]});
  }
  return out;
}

// How many of the corners are left behind the last whole triangle.
size_t spare_corners(const tinygltf::Primitive& primitive, size_t corners) {
  if (primitive.mode == TINYGLTF_MODE_TRIANGLES) return corners % 3;
  return corners < 3 ? corners : 0;
}

// Returns how many indices make no face.
size_t read_faces(const GltfDocument& doc, const Source& source, bool mirrors, size_t first, size_t count,
                  Surface& surface) {
  std::vector<std::uint32_t> corner(count);
  for (size_t i = 0; i < count; ++i) corner[i] = std::uint32_t(i);
  if (source.primitive->indices >= 0) {
    corner = read_integers(doc, source.primitive->indices, Legal::Indices, TINYGLTF_TYPE_SCALAR);
  }
  // A corner that names no vertex becomes wedge -1: `repair` counts and removes its face.
  const auto wedge = [&](std::uint32_t i) { return i < count ? int(first + i) : -1; };
  for (const auto& [a, b, c] : triangles(*source.primitive, corner)) {
    surface.add_face(std::array{wedge(a), wedge(mirrors ? c : b), wedge(mirrors ? b : c)});
  }
  return spare_corners(*source.primitive, corner.size());
}

// Adds the part's geometry to the character's surface, all but its attributes, which are returned.
Rows read_part(const GltfDocument& doc, const Source& source, int part, Character& character,
               Warnings& warnings) {
  Surface& surface = character.surface;
  const AttributeLayout has = character.parts[size_t(part)].has;
  const ChangeOfSpace to_rest(source.bound->to_rest);
  const size_t first = surface.position.size();
  const Rows positions =
      read_rows(doc, attribute(*source.primitive, "POSITION"), Legal::Position, {TINYGLTF_TYPE_VEC3});
  const size_t count = size_t(positions.rows());
  for (size_t i = 0; i < count; ++i) {
    surface.position.push_back(transform(to_rest.map, positions.row(Eigen::Index(i)).transpose()));
    surface.wedges.push_back({int(first + i), part});
  }
  for (Influences& influences : read_influences(doc, source, count))
    surface.influences.push_back(std::move(influences));
  surface.morphs.resize(first + count), surface.normal_morphs.resize(first + count);
  read_offsets(doc, source, "POSITION", to_rest.along, first, count, surface.morphs);
  if (has.normal) read_offsets(doc, source, "NORMAL", to_rest.normal, first, count, surface.normal_morphs);
  const size_t spare = read_faces(doc, source, to_rest.mirrors, first, count, surface);
  warn(warnings, {WarningCode::FaceIncomplete, character.parts[size_t(part)].name, std::int64_t(spare),
                  "indices behind the last whole triangle, left out"});
  return read_attributes(doc, source, to_rest, has, surface.layout, count);
}

// What all parts together are going to ask for, before any of it is read.
class Amounts {
 public:
  explicit Amounts(const GltfDocument& doc) : doc_(doc), most_(doc.most_elements()) {}

  void add(const Source& source) {
    const tinygltf::Primitive& primitive = *source.primitive;
    const size_t count = elements(attribute(primitive, "POSITION"));
    const size_t corners = primitive.indices >= 0 ? elements(primitive.indices) : count;
    grow(vertices_, count, std::min(most_, kMostVertices), source, "vertices");
    grow(corners_, (primitive.mode == TINYGLTF_MODE_TRIANGLES ? 1 : 3) * corners, 4 * most_, source,
         "corners of faces");
    for (const auto& target : primitive.targets) {
      grow(zero_offsets_, count, kMostZeroOffsets, source, "morph offsets");
      for (const auto& [name, accessor] : target) {
        grow(offsets_, stored_elements(accessor), most_, source, "morph offsets");
      }
    }
  }

 private:
  const tinygltf::Accessor* accessor(int index) const {
    const bool there = index >= 0 && size_t(index) < doc_.model.accessors.size();
    return there ? &doc_.model.accessors[size_t(index)] : nullptr;
  }
  // No more than one accessor may have: counts are 64 bits that may lie.
  size_t elements(int index) const {
    const tinygltf::Accessor* its = accessor(index);
    return its ? std::min(its->count, size_t(1) << 32) : 0;
  }
  size_t stored_elements(int index) const {
    const tinygltf::Accessor* its = accessor(index);
    if (!its || its->bufferView >= 0) return elements(index);
    return its->sparse.isSparse ? size_t(std::max(its->sparse.count, 0)) : 0;
  }
  void grow(size_t& sum, size_t count, size_t most, const Source& source, const char* what) const {
    sum += count;
    if (sum <= most) return;
    doc_.fail(source.accessors_of, "brings the " + std::string(what) + " to " + std::to_string(sum) +
                                       ", and a character in a file of this size has no more than " +
                                       std::to_string(most));
  }

  const GltfDocument& doc_;
  size_t most_;
  size_t vertices_ = 0, corners_ = 0, offsets_ = 0, zero_offsets_ = 0;
};

void check_sets(const GltfDocument& doc, const std::string& place, const tinygltf::Primitive& primitive) {
  for (const char* name : {"TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"}) {
    if (set_count(primitive, name) > kMostSets)
      doc.fail(place, "has more than 8 sets of " + std::string(name, std::strlen(name) - 1));
  }
}

void warn_of_what_is_left_out(const tinygltf::Primitive& primitive, const std::string& part,
                              Warnings& warnings) {
  const AttributeLayout has = layout_of(primitive);
  const size_t known = 1 + size_t(has.normal) + size_t(has.tangent) + size_t(has.uv_sets + has.colour_sets) +
                       size_t(set_count(primitive, "JOINTS_") + set_count(primitive, "WEIGHTS_"));
  const auto unknown = std::int64_t(primitive.attributes.size() - known);
  warn(warnings,
       {WarningCode::NotASkinFeature, part, unknown, "vertex attributes of the application's own, left out"});
  const auto tangents = std::count_if(primitive.targets.begin(), primitive.targets.end(),
                                      [](const auto& target) { return target.contains("TANGENT"); });
  warn(warnings, {WarningCode::MorphTangentsDropped, part, tangents, "left out"});
}

// Adds the morph targets of the mesh at `node`; returns the index of the first.
int add_morphs(const GltfDocument& doc, int node, Character& character) {
  const int first = int(character.morphs.size());
  const tinygltf::Node& from = doc.model.nodes[size_t(node)];
  const size_t m = size_t(from.mesh);
  const std::vector<double>& weights = from.weights.empty() ? doc.model.meshes[m].weights : from.weights;
  const Json& names = member(member(doc.json["meshes"][m], "extras"), "targetNames");
  for (size_t t = 0; t < size_t(target_count(doc, node)); ++t) {
    const bool named = names.is_array() && t < names.size() && names[t].is_string();
    if (named) doc.check_name(numbered("mesh", m), names[t].get_ref<const std::string&>());
    if (character.morphs.size() == kMostMorphs) doc.fail("", "has too many morph targets to be a character");
    character.morphs.push_back({.name = named ? names[t].get<std::string>() : numbered("morph", t),
                                .node = node,
                                .weight = t < weights.size() ? weights[t] : 0.0});
  }
  return first;
}

// The nodes of the scene that show a mesh.
std::vector<int> mesh_nodes(const GltfDocument& doc, Warnings& warnings) {
  const std::vector<bool> inside = nodes_in_scene(doc);
  std::vector<int> nodes;
  for (size_t n = 0; n < doc.model.nodes.size(); ++n) {
    const int mesh = doc.model.nodes[n].mesh;
    if (mesh < 0) continue;
    if (!inside[n]) {
      const std::string& name = doc.model.nodes[n].name;
      warn(warnings, {WarningCode::MeshOutsideScene, name.empty() ? numbered("node", n) : name, 1,
                      "not in the scene that is read, left out"});
      continue;
    }
    if (size_t(mesh) >= doc.model.meshes.size())
      doc.fail(numbered("node", n), "its mesh " + std::to_string(mesh) + " does not exist");
    nodes.push_back(int(n));
  }
  return nodes;
}

// Skins first: they settle where rest space is, and rigid meshes go where their node then stands in it.
std::map<int, BoundSkin> bind_nodes(const GltfDocument& doc, const std::vector<int>& nodes,
                                    Skeleton& skeleton) {
  std::map<int, BoundSkin> by_skin, by_node;
  for (const int n : nodes) {
    if (const int skin = doc.model.nodes[size_t(n)].skin; skin >= 0) by_skin[skin];
  }
  if (by_skin.size() > kMostSkins) doc.fail("", "has too many skins to be a character");
  for (auto& [skin, bound] : by_skin) bound = add_skin(skeleton, read_skin(doc, skin));
  if (by_skin.empty()) {
    doc.fail("", "no skin: no mesh of its scene is bound to joints",
             "give a rigged character, exported with its skin");
  }
  for (const int n : nodes) {
    const int skin = doc.model.nodes[size_t(n)].skin;
    by_node[n] = skin >= 0 ? by_skin[skin] : add_skin(skeleton, std::array{Joint{.node = n}});
  }
  return by_node;
}

}  // namespace

void read_surface(GltfDocument& doc, Character& character, Warnings& warnings) {
  const std::vector<int> nodes = mesh_nodes(doc, warnings);
  if (nodes.size() > kMostParts) doc.fail("", "has too many meshes to be a character");
  const std::map<int, BoundSkin> bound = bind_nodes(doc, nodes, character.skeleton);

  std::vector<Source> sources;
  Surface& surface = character.surface;
  for (const int n : nodes) {
    const tinygltf::Node& node = doc.model.nodes[size_t(n)];
    const tinygltf::Mesh& mesh = doc.model.meshes[size_t(node.mesh)];
    const std::string mesh_name = mesh.name.empty() ? numbered("mesh", size_t(node.mesh)) : mesh.name;
    const std::string name = node.name.empty() ? mesh_name : node.name;
    const int first_morph = add_morphs(doc, n, character);
    for (size_t p = 0; p < mesh.primitives.size(); ++p) {
      const tinygltf::Primitive& primitive = mesh.primitives[p];
      const std::string part = mesh.primitives.size() == 1 ? name : name + "[" + std::to_string(p) + "]";
      const std::string place = numbered("mesh", size_t(node.mesh)) + ": " + numbered("primitive", p);
      if (!is_triangles(primitive)) {
        if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
          doc.fail(place, "has mode " + std::to_string(primitive.mode));
        warn(warnings, {WarningCode::NotASkinFeature, part, 1, "points or lines, left out"});
        continue;
      }
      if (attribute(primitive, "POSITION") < 0) doc.fail(place, "has no POSITION");
      if (primitive.material >= int(character.materials.size()))
        doc.fail(place, "its material does not exist");
      check_sets(doc, place, primitive);
      warn_of_what_is_left_out(primitive, part, warnings);
      const AttributeLayout has = layout_of(primitive);
      surface.layout = joined(surface.layout, has);
      character.parts.push_back({.name = part, .node = n, .material = primitive.material, .has = has});
      sources.push_back({&primitive, &bound.at(n), node.skin >= 0, place, first_morph});
      doc.primitives.push_back(int(p));
    }
  }
  if (sources.size() > kMostParts) doc.fail("", "has too many primitives to be a character");
  Amounts amounts(doc);
  for (const Source& source : sources) amounts.add(source);

  std::vector<Rows> attributes;
  for (size_t p = 0; p < sources.size(); ++p) {
    attributes.push_back(read_part(doc, sources[p], int(p), character, warnings));
  }
  surface.attributes = stacked(attributes, surface.layout.columns());
  const auto is_empty = [](const MorphOffsets& offsets) { return offsets.empty(); };
  if (std::all_of(surface.morphs.begin(), surface.morphs.end(), is_empty)) surface.morphs.clear();
  if (std::all_of(surface.normal_morphs.begin(), surface.normal_morphs.end(), is_empty))
    surface.normal_morphs.clear();
  if (surface.face_count() == 0) doc.fail("", "has no faces", "give a file with a mesh of triangles");
}

}  // namespace skinlod
