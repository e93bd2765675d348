// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "formats/gltf_accessor.h"
#include "formats/gltf_read.h"

namespace skinlod {
namespace {

// The work per node is not quite constant, and a forged file can hold millions of them.
constexpr size_t kMostNodes = size_t(1) << 14;

// The upper rows of a glTF matrix, which is stored by columns; none where the last row is not 0 0 0 1.
std::optional<Affine> affine_of_columns(const double* m) {
  if (!(std::abs(m[3]) + std::abs(m[7]) + std::abs(m[11]) + std::abs(m[15] - 1) < 1e-3)) return {};
  return Eigen::Map<const Eigen::Matrix4d>(m).topRows<3>();
}

template <class Vector>
Vector vector_or(const GltfDocument& doc, const std::string& part, const std::vector<double>& given,
                 const Vector& otherwise) {
  if (given.empty()) return otherwise;
  if (given.size() != size_t(otherwise.size())) doc.fail(part, "has a transform of a wrong length");
  return Eigen::Map<const Vector>(given.data());
}

Node read_node(const GltfDocument& doc, size_t n) {
  const tinygltf::Node& from = doc.model.nodes[n];
  const std::string part = numbered("node", n);
  Node node{.name = from.name};
  if (from.matrix.empty()) {
    node.rest.translation = vector_or<Vec3>(doc, part, from.translation, Vec3::Zero());
    node.rest.rotation = vector_or<Quat>(doc, part, from.rotation, Quat(0, 0, 0, 1));
    node.rest.scale = vector_or<Vec3>(doc, part, from.scale, Vec3::Ones());
    return node;
  }
  if (from.matrix.size() != 16) doc.fail(part, "has a matrix of a wrong length");
  const std::optional<Affine> matrix = affine_of_columns(from.matrix.data());
  if (!matrix) doc.fail(part, "has a matrix that is no affine map");
  node.rest = decompose(*matrix);
  const double size = matrix->cwiseAbs().maxCoeff();
  if (!((affine(node.rest) - *matrix).cwiseAbs().maxCoeff() <= 1e-6 * size)) node.matrix = matrix;
  return node;
}

// From the roots down, so that a long chain takes no more time than a bush.
void check_no_circle(const GltfDocument& doc, const Skeleton& skeleton) {
  std::vector<int> open;
  std::vector<bool> reached(skeleton.nodes.size(), false);
  for (size_t n = 0; n < skeleton.nodes.size(); ++n) {
    if (skeleton.nodes[n].parent < 0) open.push_back(int(n));
  }
  while (!open.empty()) {
    const auto n = size_t(open.back());
    open.pop_back();
    reached[n] = true;
    open.insert(open.end(), doc.model.nodes[n].children.begin(), doc.model.nodes[n].children.end());
  }
  const auto lost = std::find(reached.begin(), reached.end(), false);
  if (lost != reached.end()) doc.fail(numbered("node", size_t(lost - reached.begin())), "hangs in a circle");
}

}  // namespace

std::string numbered(const char* what, size_t index) {
  return std::string(what) + " " + std::to_string(index);
}

Skeleton read_nodes(GltfDocument& doc, Warnings& warnings) {
  const size_t count = doc.model.nodes.size();
  if (count > kMostNodes) doc.fail("", "has " + std::to_string(count) + " nodes, more than 16384");
  Skeleton skeleton;
  for (size_t n = 0; n < count; ++n) {
    Node& node = skeleton.nodes.emplace_back(read_node(doc, n));
    if (node.rest.rotation.norm() != 0) continue;
    node.rest.rotation = Transform{}.rotation;
    doc.json["nodes"][n].erase("rotation");
    warn(warnings, {WarningCode::RotationZero, node.name.empty() ? numbered("node", n) : node.name, 1,
                    "taken for no rotation"});
  }
  for (size_t n = 0; n < count; ++n) {
    for (const int child : doc.model.nodes[n].children) {
      if (size_t(child) >= count)
        doc.fail(numbered("node", n), "its child " + std::to_string(child) + " does not exist");
      int& parent = skeleton.nodes[size_t(child)].parent;
      if (parent >= 0) doc.fail(numbered("node", size_t(child)), "has two parents");
      parent = int(n);
    }
  }
  check_no_circle(doc, skeleton);
  return skeleton;
}

void drop_repeated_roots(GltfDocument& doc, Warnings& warnings) {
  if (!doc.json.contains("scenes")) return;
  for (size_t s = 0; s < doc.json["scenes"].size(); ++s) {
    Json& scene = doc.json["scenes"][s];
    if (!scene.contains("nodes")) continue;
    Json kept = Json::array();
    std::set<int> listed;
    for (const Json& node : scene["nodes"]) {
      if (listed.insert(node.get<int>()).second) kept.push_back(node);
    }
    warn(warnings, {WarningCode::SceneNodeTwice, numbered("scene", s),
                    std::int64_t(scene["nodes"].size() - kept.size()), "listed once"});
    scene["nodes"] = std::move(kept);
  }
}

std::vector<bool> nodes_in_scene(const GltfDocument& doc) {
  const tinygltf::Model& model = doc.model;
  if (model.scenes.empty()) return std::vector<bool>(model.nodes.size(), true);
  const size_t scene = model.defaultScene < 0 ? 0 : size_t(model.defaultScene);
  if (scene >= model.scenes.size()) doc.fail(numbered("scene", scene), "does not exist");
  std::vector<bool> inside(model.nodes.size(), false);
  std::vector<int> open = model.scenes[scene].nodes;
  while (!open.empty()) {
    const int n = open.back();
    open.pop_back();
    if (size_t(n) >= inside.size())
      doc.fail(numbered("scene", scene), "its node " + std::to_string(n) + " does not exist");
    if (inside[size_t(n)]) continue;
    inside[size_t(n)] = true;
    open.insert(open.end(), model.nodes[size_t(n)].children.begin(), model.nodes[size_t(n)].children.end());
  }
  return inside;
}

std::vector<Joint> read_skin(const GltfDocument& doc, int index) {
  const std::string part = "skin " + std::to_string(index);
  if (index < 0 || size_t(index) >= doc.model.skins.size()) doc.fail(part, "does not exist");
  const tinygltf::Skin& skin = doc.model.skins[size_t(index)];
  if (skin.joints.empty()) doc.fail(part, "has no joints");
  std::vector<Joint> joints;
  for (const int node : skin.joints) {
    if (size_t(node) >= doc.model.nodes.size())
      doc.fail(part, "its joint " + std::to_string(node) + " does not exist");
    joints.push_back({.node = node});
  }
  if (skin.inverseBindMatrices < 0) return joints;
  const Rows matrices = read_rows(doc, skin.inverseBindMatrices, Legal::Matrix, {TINYGLTF_TYPE_MAT4});
  if (size_t(matrices.rows()) < joints.size()) doc.fail(part, "has fewer inverse bind matrices than joints");
  for (size_t j = 0; j < joints.size(); ++j) {
    const std::optional<Affine> matrix = affine_of_columns(matrices.row(Eigen::Index(j)).data());
    if (!matrix || !matrix->allFinite())
      doc.fail(part, "inverse bind matrix " + std::to_string(j) + " is no affine map");
    joints[j].inverse_bind = *matrix;
  }
  return joints;
}

std::optional<size_t> base_colour_image(const GltfDocument& doc, size_t material) {
  const auto item = [&](const char* list, const Json& index) -> const Json& {
    static const Json none;
    const Json& items = member(doc.json, list);
    return index.is_number() && index.get<size_t>() < items.size() ? items[index.get<size_t>()] : none;
  };
  const Json& look = member(item("materials", material), "pbrMetallicRoughness");
  const Json& image = member(item("textures", member(member(look, "baseColorTexture"), "index")), "source");
  if (!image.is_number() || image.get<size_t>() >= doc.images.size()) return std::nullopt;
  return image.get<size_t>();
}

std::vector<Material> read_materials(const GltfDocument& doc) {
  std::vector<Material> materials;
  for (size_t m = 0; m < doc.model.materials.size(); ++m) {
    const tinygltf::Material& from = doc.model.materials[m];
    const auto image = base_colour_image(doc, m);
    const Json uri = image ? member(doc.json["images"][*image], "uri") : Json();
    Material& material = materials.emplace_back();
    material.name = from.name;
    material.base_colour = Eigen::Map<const Vec4>(from.pbrMetallicRoughness.baseColorFactor.data());
    material.double_sided = from.doubleSided;
    if (uri.is_string() && !uri.get_ref<const std::string&>().starts_with("data:")) material.texture = uri;
  }
  return materials;
}

}  // namespace skinlod
