// SPDX-License-Identifier: MIT
#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/gltf.h"
#include "formats/gltf_builder.h"
#include "formats/gltf_document.h"
#include "formats/gltf_keep.h"
#include "formats/gltf_scene.h"
#include "formats/gltf_space.h"
#include "pipeline/error.h"
#include "pipeline/morphs.h"

namespace skinlod {
namespace {

// A part's share of a surface: its wedges by index, and its triangles by place among them.
struct Primitive {
  int part;
  std::vector<int> wedges;
  std::vector<std::uint32_t> corners;
};

// The mesh at a node.
struct NodeMesh {
  int node;
  std::vector<Primitive> primitives;  // in the order of parts
  std::optional<int> rigid;           // the joint that all of it follows, if it is one on the node itself
  std::vector<int> morphs;
};

// The one skin of the file: glTF wants each node in it once, so that a node's second joint stands on a child
// of it without a transform of its own.
struct FileSkin {
  std::vector<int> joints;  // of the skeleton
  std::vector<int> slot;    // per joint of the skeleton: its place in the skin, or -1
  int influence_sets = 1;   // of four influences each, as many as the richest vertex needs
};

std::vector<Primitive> primitives_of(const Surface& surface, int parts) {
  std::vector<Primitive> primitives;
  for (int p = 0; p < parts; ++p) primitives.push_back({p, {}, {}});
  for (int f = 0; f < surface.face_count(); ++f) {
    std::vector<int>& wedges = primitives[size_t(surface.part(f))].wedges;
    wedges.insert(wedges.end(), surface.face(f).begin(), surface.face(f).end());
  }
  std::vector<std::uint32_t> place(surface.wedges.size());
  for (Primitive& primitive : primitives) {
    std::sort(primitive.wedges.begin(), primitive.wedges.end());
    primitive.wedges.erase(std::unique(primitive.wedges.begin(), primitive.wedges.end()),
                           primitive.wedges.end());
    for (size_t i = 0; i < primitive.wedges.size(); ++i)
      place[size_t(primitive.wedges[i])] = std::uint32_t(i);
  }
  for (int f = 0; f < surface.face_count(); ++f) {
    for (const int wedge : surface.face(f))
      primitives[size_t(surface.part(f))].corners.push_back(place[size_t(wedge)]);
  }
  return primitives;
}

const Influences& influences_of(const Surface& surface, int wedge) {
  return surface.influences[size_t(surface.wedges[size_t(wedge)].vertex)];
}

std::optional<int> rigid_joint(const Character& character, const Surface& surface, const NodeMesh& mesh) {
  const Influences& first = influences_of(surface, mesh.primitives[0].wedges[0]);
  if (first.empty() || character.skeleton.joints[size_t(first[0].joint)].node != mesh.node) return {};
  for (const Primitive& primitive : mesh.primitives) {
    for (const int wedge : primitive.wedges) {
      const Influences& influences = influences_of(surface, wedge);
      if (influences.size() != 1 || influences[0].joint != first[0].joint) return {};
    }
  }
  return first[0].joint;
}

// The meshes that still have faces, by node.
std::vector<NodeMesh> meshes_of(const Character& character, const Surface& surface) {
  std::map<int, NodeMesh> by_node;
  for (Primitive& primitive : primitives_of(surface, int(character.parts.size()))) {
    if (primitive.corners.empty()) continue;
    const int node = character.parts[size_t(primitive.part)].node;
    NodeMesh& mesh = by_node.try_emplace(node, NodeMesh{node, {}, {}, {}}).first->second;
    mesh.primitives.push_back(std::move(primitive));
  }
  std::vector<NodeMesh> meshes;
  for (auto& [node, mesh] : by_node) {
    mesh.rigid = rigid_joint(character, surface, mesh);
    for (int m = 0; m < int(character.morphs.size()); ++m) {
      if (character.morphs[size_t(m)].node == node) mesh.morphs.push_back(m);
    }
    meshes.push_back(std::move(mesh));
  }
  return meshes;
}

// All joints but those that are there for a rigid mesh alone.
FileSkin skin_of(const Character& character, const Surface& surface, const std::vector<NodeMesh>& meshes) {
  const std::vector<Joint>& joints = character.skeleton.joints;
  std::vector<bool> carries_mesh(character.skeleton.nodes.size(), false);
  for (const Part& part : character.parts) carries_mesh[size_t(part.node)] = true;
  std::vector<bool> inside(joints.size());
  for (size_t b = 0; b < joints.size(); ++b) inside[b] = !carries_mesh[size_t(joints[b].node)];
  size_t most = 1;
  bool is_skinned = false;
  for (const NodeMesh& mesh : meshes) {
    if (mesh.rigid) continue;
    is_skinned = true;
    for (const Primitive& primitive : mesh.primitives) {
      for (const int wedge : primitive.wedges) {
        const Influences& influences = influences_of(surface, wedge);
        most = std::max(most, influences.size());
        for (const Influence& influence : influences) inside[size_t(influence.joint)] = true;
      }
    }
  }
  FileSkin skin{
      .joints = {}, .slot = std::vector<int>(joints.size(), -1), .influence_sets = int(most + 3) / 4};
  for (size_t b = 0; b < joints.size(); ++b) {
    if (is_skinned && inside[b]) skin.slot[b] = int(skin.joints.size()), skin.joints.push_back(int(b));
  }
  return skin;
}

// Largest weight first, for readers that take the first four. As floats: their sum is 1 to the last bit or
// two, while 8 bits would move a vertex by up to 1/255 of the distance between its joints. Those 8 bits are
// the runtime format's business.
Influences for_file(const Influences& influences) {
  Influences sorted;
  double sum = 0;
  for (const Influence& influence : influences) sum += influence.weight;
  for (const auto& [joint, weight] : influences) {
    if (const float share = float(weight / sum); share > 0) sorted.push_back({joint, double(share)});
  }
  if (sorted.empty()) throw Error{Fault::Ours, "a vertex without influence reached the glTF writer"};
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Influence& a, const Influence& b) { return a.weight > b.weight; });
  double others = 0;
  for (size_t i = 1; i < sorted.size(); ++i) others += sorted[i].weight;
  sorted[0].weight = 1 - others;
  return sorted;
}

void add_influences(const Surface& surface, const Primitive& primitive, const FileSkin& skin,
                    Json& attributes, GltfBuilder& glb) {
  const size_t count = primitive.wedges.size();
  for (int set = 0; set < skin.influence_sets; ++set) {
    std::vector<std::uint32_t> joints(4 * count, 0);
    Rows weights = Rows::Zero(Eigen::Index(count), 4);
    for (size_t i = 0; i < count; ++i) {
      const Influences influences = for_file(influences_of(surface, primitive.wedges[i]));
      for (size_t k = 0; k < 4 && 4 * size_t(set) + k < influences.size(); ++k) {
        const Influence& influence = influences[4 * size_t(set) + k];
        joints[4 * i + k] = std::uint32_t(skin.slot[size_t(influence.joint)]);
        weights(Eigen::Index(i), Eigen::Index(k)) = influence.weight;
      }
    }
    const std::string suffix = "_" + std::to_string(set);
    attributes["JOINTS" + suffix] =
        glb.add_integers(joints, 4, skin.joints.size() <= 256 ? 1 : 2, Use::Vertex);
    attributes["WEIGHTS" + suffix] = glb.add_floats(weights, Use::Vertex);
  }
}

// The attribute columns from `at` on, of the primitive's wedges.
Rows columns(const Surface& surface, const Primitive& primitive, int at, int count) {
  Rows rows(Eigen::Index(primitive.wedges.size()), count);
  for (size_t i = 0; i < primitive.wedges.size(); ++i) {
    rows.row(Eigen::Index(i)) = surface.attributes.row(primitive.wedges[i]).segment(at, count);
  }
  return rows;
}

Json attributes_of(const Surface& surface, const AttributeLayout& has, const Primitive& primitive,
                   const ChangeOfSpace& to_file, GltfBuilder& glb) {
  Json attributes;
  Rows position(Eigen::Index(primitive.wedges.size()), 3);
  for (size_t i = 0; i < primitive.wedges.size(); ++i) {
    const int vertex = surface.wedges[size_t(primitive.wedges[i])].vertex;
    position.row(Eigen::Index(i)) = transform(to_file.map, surface.position[size_t(vertex)]).transpose();
  }
  attributes["POSITION"] = glb.add_floats(position, Use::Vertex);
  const AttributeLayout& layout = surface.layout;
  if (has.normal) {
    Rows normal = columns(surface, primitive, layout.normal_at(), 3) * to_file.normal.transpose();
    normal.rowwise().normalize();
    attributes["NORMAL"] = glb.add_floats(normal, Use::Vertex);
  }
  if (has.tangent) {
    Rows tangent = columns(surface, primitive, layout.tangent_at(), 4);
    for (Eigen::Index i = 0; i < tangent.rows(); ++i) {
      tangent.row(i).head<3>() = unit(to_file.along * tangent.row(i).head<3>().transpose()).transpose();
      tangent(i, 3) = (tangent(i, 3) < 0) == to_file.mirrors ? 1 : -1;
    }
    attributes["TANGENT"] = glb.add_floats(tangent, Use::Vertex);
  }
  for (int set = 0; set < has.uv_sets; ++set) {
    attributes["TEXCOORD_" + std::to_string(set)] =
        glb.add_floats(columns(surface, primitive, layout.uv_at(set), 2), Use::Vertex);
  }
  for (int set = 0; set < has.colour_sets; ++set) {
    const Rows colour = columns(surface, primitive, layout.colour_at(set), 4).cwiseMax(0).cwiseMin(1);
    attributes["COLOR_" + std::to_string(set)] = glb.add_floats(colour, Use::Vertex);
  }
  return attributes;
}

// One row per wedge: what the target adds to it.
Rows offsets(const std::vector<MorphOffsets>& morphs, const std::vector<int>& items, int morph,
             const Mat3& to_file) {
  Rows rows = Rows::Zero(Eigen::Index(items.size()), 3);
  for (size_t i = 0; i < items.size() && !morphs.empty(); ++i)
    rows.row(Eigen::Index(i)) = (to_file * offset_of(morphs[size_t(items[i])], morph)).transpose();
  return rows;
}

Json targets_of(const Surface& surface, bool has_normal, const Primitive& primitive,
                const std::vector<int>& morphs, const ChangeOfSpace& to_file, GltfBuilder& glb) {
  std::vector<int> vertices;
  for (const int wedge : primitive.wedges) vertices.push_back(surface.wedges[size_t(wedge)].vertex);
  Json targets = Json::array();
  for (const int morph : morphs) {
    Json& target = targets.emplace_back();
    target["POSITION"] = glb.add_sparse(offsets(surface.morphs, vertices, morph, to_file.along));
    if (!has_normal || surface.normal_morphs.empty()) continue;
    const Rows normals = offsets(surface.normal_morphs, primitive.wedges, morph, to_file.normal);
    target["NORMAL"] = glb.add_sparse(normals);
  }
  return targets;
}

// Writes one primitive over `json`, which holds what is kept of the source's.
void add_primitive(const Character& character, const Surface& surface, const NodeMesh& mesh,
                   const Primitive& primitive, const FileSkin& skin, Json& json, GltfBuilder& glb) {
  const Part& part = character.parts[size_t(primitive.part)];
  const ChangeOfSpace to_file(mesh.rigid ? character.skeleton.joints[size_t(*mesh.rigid)].inverse_bind
                                         : identity());
  Json attributes = attributes_of(surface, part.has, primitive, to_file, glb);
  if (!mesh.rigid) add_influences(surface, primitive, skin, attributes, glb);
  json["attributes"] = std::move(attributes);
  if (part.material >= 0) json["material"] = part.material;
  if (!mesh.morphs.empty())
    json["targets"] = targets_of(surface, part.has.normal, primitive, mesh.morphs, to_file, glb);
  std::vector<std::uint32_t> corners = primitive.corners;
  for (size_t i = 0; to_file.mirrors && i + 2 < corners.size(); i += 3)
    std::swap(corners[i + 1], corners[i + 2]);
  json["indices"] = glb.add_integers(corners, 1, primitive.wedges.size() <= 65535 ? 2 : 4, Use::Index);
}

// What the source says of a mesh or primitive beside its geometry.
Json kept_primitive(const GltfDocument& doc, int node, int part) {
  const int mesh = doc.model.nodes[size_t(node)].mesh;
  Json json = doc.json["meshes"][size_t(mesh)]["primitives"][size_t(doc.primitives[size_t(part)])];
  for (const char* key : {"attributes", "indices", "mode", "targets"}) json.erase(key);
  if (Json& extensions = json["extensions"]; extensions.is_object())
    extensions.erase("KHR_draco_mesh_compression");
  if (json["extensions"].empty()) json.erase("extensions");
  return json;
}

Json kept_mesh(const GltfDocument& doc, int index, const NodeMesh& mesh) {
  Json json = doc.json["meshes"][size_t(index)];
  if (!mesh.morphs.empty()) return json;
  json.erase("weights");
  if (json.contains("extras") && json["extras"].is_object()) json["extras"].erase("targetNames");
  return json;
}

Json new_mesh(const Character& character, const NodeMesh& mesh) {
  Json json = Json::object();
  const Node& node = character.skeleton.nodes[size_t(mesh.node)];
  json["name"] = node.name.empty() ? character.parts[size_t(mesh.primitives[0].part)].name : node.name;
  for (const int m : mesh.morphs) {
    json["weights"].push_back(character.morphs[size_t(m)].weight);
    json["extras"]["targetNames"].push_back(character.morphs[size_t(m)].name);
  }
  return json;
}

// The document's mesh at the node; none for what another file has added.
std::optional<int> mesh_in(const GltfDocument* doc, int node) {
  if (!doc || size_t(node) >= doc->model.nodes.size() || doc->model.nodes[size_t(node)].mesh < 0) return {};
  return doc->model.nodes[size_t(node)].mesh;
}

// Meshes keep the order they have in the source, which extensions may count on; new ones follow.
void sort_as_in(const GltfDocument& doc, std::vector<NodeMesh>& meshes) {
  const int last = int(doc.model.meshes.size());
  std::map<int, int> instances;
  std::map<int, std::pair<int, int>> rank;  // by node
  for (const NodeMesh& mesh : meshes) {
    const int index = mesh_in(&doc, mesh.node).value_or(last);
    rank[mesh.node] = {index == last ? 0 : instances[index]++, index};
  }
  std::stable_sort(meshes.begin(), meshes.end(),
                   [&](const NodeMesh& a, const NodeMesh& b) { return rank[a.node] < rank[b.node]; });
}

void add_meshes(const Character& character, const Surface& surface, const std::vector<NodeMesh>& meshes,
                const FileSkin& skin, const GltfDocument* doc, GltfBuilder& glb) {
  for (const NodeMesh& mesh : meshes) {
    Json& node = glb.json["nodes"][size_t(mesh.node)];
    node["mesh"] = glb.json["meshes"].size();
    if (!mesh.rigid) node["skin"] = 0;
    const std::optional<int> kept = mesh_in(doc, mesh.node);
    Json json = kept ? kept_mesh(*doc, *kept, mesh) : new_mesh(character, mesh);
    json["primitives"] = Json::array();
    for (const Primitive& primitive : mesh.primitives) {
      Json& entry = json["primitives"].emplace_back(kept ? kept_primitive(*doc, mesh.node, primitive.part)
                                                         : Json::object());
      add_primitive(character, surface, mesh, primitive, skin, entry, glb);
    }
    glb.json["meshes"].push_back(std::move(json));
  }
}

int root_of(const Skeleton& skeleton, int node) {
  while (skeleton.nodes[size_t(node)].parent >= 0) node = skeleton.nodes[size_t(node)].parent;
  return node;
}

// The joints of a skin must have a common root; several roots are hung on a new one that leaves them in
// place.
void join_roots(const Skeleton& skeleton, const FileSkin& skin, Json& json) {
  std::vector<int> roots;
  for (const int b : skin.joints) roots.push_back(root_of(skeleton, skeleton.joints[size_t(b)].node));
  std::sort(roots.begin(), roots.end());
  roots.erase(std::unique(roots.begin(), roots.end()), roots.end());
  if (roots.size() < 2) return;
  const size_t common = json["nodes"].size();
  json["nodes"].push_back({{"name", "skeleton"}, {"children", roots}});
  if (!json.contains("scenes")) return;
  for (Json& scene : json["scenes"]) {
    if (!scene.contains("nodes")) continue;
    Json kept = Json::array();
    for (const Json& node : scene["nodes"]) {
      if (!std::binary_search(roots.begin(), roots.end(), node.get<int>())) kept.push_back(node);
    }
    if (kept.size() < scene["nodes"].size()) kept.push_back(common);
    scene["nodes"] = std::move(kept);
  }
}

void add_skin_of(const Skeleton& skeleton, const FileSkin& skin, const GltfDocument* doc, GltfBuilder& glb) {
  if (skin.joints.empty()) return;
  Json json = Json::object();
  if (doc) {
    const auto is_bound = [](const tinygltf::Node& node) { return node.mesh >= 0 && node.skin >= 0; };
    const auto& nodes = doc->model.nodes;
    json = doc->json["skins"][size_t(std::find_if(nodes.begin(), nodes.end(), is_bound)->skin)];
    json.erase("skeleton");
  }
  json["joints"] = Json::array();
  std::vector<bool> is_taken(skeleton.nodes.size(), false);
  Rows binds(Eigen::Index(skin.joints.size()), 16);
  for (size_t j = 0; j < skin.joints.size(); ++j) {
    const Joint& joint = skeleton.joints[size_t(skin.joints[j])];
    size_t node = size_t(joint.node);
    if (is_taken[node]) {
      node = glb.json["nodes"].size();
      glb.json["nodes"].push_back({{"name", skeleton.nodes[size_t(joint.node)].name + ".bind"}});
      glb.json["nodes"][size_t(joint.node)]["children"].push_back(node);
    } else {
      is_taken[node] = true;
    }
    json["joints"].push_back(node);
    Eigen::Matrix4d bind = Eigen::Matrix4d::Identity();
    bind.topRows<3>() = joint.inverse_bind;
    binds.row(Eigen::Index(j)) = bind.reshaped().transpose();
  }
  json["inverseBindMatrices"] = glb.add_floats(binds, Use::Bind);
  glb.json["skins"] = Json::array({std::move(json)});
  join_roots(skeleton, skin, glb.json);
}

}  // namespace

std::vector<std::byte> write_glb(const Character& character, const Surface& surface,
                                 const GltfDocument* document) {
  if (document && document->primitives.size() > character.parts.size()) {
    throw Error{Fault::Ours, "the character's parts are not those of its glTF document"};
  }
  const Surface faces = triangulated(surface);
  std::vector<NodeMesh> meshes = meshes_of(character, faces);
  if (document) sort_as_in(*document, meshes);
  std::vector<bool> has_morphs(character.skeleton.nodes.size(), false);
  for (const NodeMesh& mesh : meshes) has_morphs[size_t(mesh.node)] = !mesh.morphs.empty();
  const FileSkin skin = skin_of(character, faces, meshes);

  GltfBuilder glb;
  std::span<const Clip> new_clips = character.clips;
  if (document) {
    keep_document(*document, has_morphs, glb);
    add_nodes(character, document->model.nodes.size(), glb.json);
    split_moved_matrices(character, glb.json);
    new_clips = new_clips.subspan(std::min(new_clips.size(), document->model.animations.size()));
  } else {
    glb.json = scene_of(character);
  }
  glb.json["asset"]["generator"] = "skinlod";
  add_meshes(character, faces, meshes, skin, document, glb);
  add_skin_of(character.skeleton, skin, document, glb);
  for (size_t n = 0; n < has_morphs.size(); ++n) {
    if (!has_morphs[n]) glb.json["nodes"][n].erase("weights");
  }
  add_clips(new_clips, has_morphs, glb);
  return glb.finish();
}

}  // namespace skinlod
