// SPDX-License-Identifier: MIT
#include "formats/assimp_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <set>

#include "pipeline/error.h"
#include "pipeline/rotation.h"

namespace skinlod {
namespace {

Vec3 vec3(const aiVector3D& v) { return {double(v.x), double(v.y), double(v.z)}; }

Quat quat(const aiQuaternion& q) {
  return normalised(Quat(double(q.x), double(q.y), double(q.z), double(q.w)));
}

/// What a format means by its numbers.
struct Convention {
  double unit = 1;                // metres
  Mat3 world = Mat3::Identity();  // world axes from the file's: x right, y up, z to the front
  double ticks_per_second = 25;   // where a clip does not say; 25 is Assimp's own reading of silence
  bool moves_turned = false;      // of keys from the rest pose: turned by it, which they must not be
};

/// FBX says its unit (in centimetres) and axes in its settings, which Assimp 5.2 hands on but does not apply.
void read_fbx_settings(const aiMetadata& settings, Convention& convention) {
  float centimetres = 0;
  if (settings.Get("UnitScaleFactor", centimetres) && std::isfinite(centimetres) && centimetres > 0) {
    convention.unit = 0.01 * double(centimetres);
  }
  Mat3 world = Mat3::Zero();
  int row = 0;
  for (const std::string axis : {"Coord", "Up", "Front"}) {
    std::int32_t column = -1, sign = 1;
    settings.Get(axis + "Axis", column), settings.Get(axis + "AxisSign", sign);
    if (column >= 0 && column < 3) world(row, column) = sign < 0 ? -1 : 1;
    ++row;
  }
  // Anything but a turn (axes named twice, a left-handed system) is no statement to act on.
  if (world.determinant() == 1) convention.world = world;
}

std::string ending(const std::string& path) {
  std::string text = std::filesystem::path(path).extension().string();
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

Convention convention_of(const aiScene& scene, const std::string& path) {
  Convention convention;
  const std::string format = ending(path);
  if (format == ".fbx" && scene.mMetaData) read_fbx_settings(*scene.mMetaData, convention);
  if (format == ".x") convention.ticks_per_second = 4800;  // Direct3D's default
  // Ogre adds a key's translation to the bone's own; Assimp puts all of the key behind all of the rest pose.
  convention.moves_turned = format == ".mesh" || format == ".xml";
  if (format == ".b3d") convention.ticks_per_second = 60;  // Blitz3D's default
  return convention;
}

/// The clock of a clip.
struct Ticks {
  double begin, per_second;
  double seconds(double time) const { return (time - begin) / per_second; }
};

class SceneReader {
 public:
  SceneReader(const aiScene& scene, const std::string& path)
      : scene_(scene), path_(path), convention_(convention_of(scene, path)) {}

  Imported read(Need need) &&;

 private:
  /// A mesh at a node.
  struct Instance {
    int node;
    const aiMesh* mesh;
    std::vector<int> bones;  // of the mesh, those that are nodes
    BoundSkin skin;
  };

  void add_nodes(const aiNode& node, int parent);
  int node_named(const std::string& name);
  std::vector<int> twins(const std::string& name) const;

  void add_materials();
  void add_meshes();
  std::vector<Instance> instances();
  void bind(std::vector<Instance>& instances);
  void add_part(const Instance& instance);
  void add_vertices(const Instance& instance, int part);
  void add_influences(const Instance& instance, int first_vertex);
  void add_faces(const Instance& instance, int first_wedge);
  void add_morphs(const Instance& instance, int first_vertex);
  int morph(int node, const std::string& name);

  void add_clips();
  Clip clip(const aiAnimation& animation, const std::string& name);
  Channel morph_channel(int node, std::span<const aiMeshMorphKey> keys, const Ticks& ticks) const;

  Affine affine_of(const aiMatrix4x4& m) const;
  std::string part_name(const Instance& instance) const;
  void note(WarningCode code, std::string part, std::int64_t count, std::string detail = {}) {
    warn(imported_.warnings, {code, std::move(part), count, std::move(detail)});
  }

  const aiScene& scene_;
  const std::string& path_;
  const Convention convention_;
  Imported imported_{};
  Character& character_ = imported_.character;
  Surface& surface_ = imported_.character.surface;
  std::vector<const aiNode*> source_{};                // per node
  std::map<std::string, std::vector<int>> by_name_{};  // nodes of a name, in the file's order
  std::set<std::string> bone_names_{};
  std::map<std::string, int> meant_{};  // node_named's answers
};

Imported SceneReader::read(Need need) && {
  add_nodes(*scene_.mRootNode, -1);
  if (!convention_.world.isIdentity(0)) {
    Affine turned = identity();
    turned.leftCols<3>() = convention_.world;
    Node& root = character_.skeleton.nodes.front();
    root.rest = decompose(compose(turned, affine(root.rest)));
  }
  for (unsigned m = 0; m < scene_.mNumMeshes; ++m) {
    for (unsigned b = 0; b < scene_.mMeshes[m]->mNumBones; ++b) {
      bone_names_.insert(scene_.mMeshes[m]->mBones[b]->mName.C_Str());
    }
  }
  if (need == Need::Character) {
    add_materials();
    add_meshes();
    note(WarningCode::NotASkinFeature, "", scene_.mNumCameras + scene_.mNumLights, "cameras and lights");
  }
  add_clips();
  return std::move(imported_);
}

// Lengths are scaled to metres one by one and not by a scale on the root: joints stay free of scale, and the
// translations of two files in different units mean the same.
Affine SceneReader::affine_of(const aiMatrix4x4& m) const {
  Affine a;
  a << double(m.a1), double(m.a2), double(m.a3), double(m.a4) * convention_.unit,  //
      double(m.b1), double(m.b2), double(m.b3), double(m.b4) * convention_.unit,   //
      double(m.c1), double(m.c2), double(m.c3), double(m.c4) * convention_.unit;
  return a;
}

void SceneReader::add_nodes(const aiNode& source, int parent) {
  const int index = int(source_.size());
  const Affine local = affine_of(source.mTransformation);
  Node node{source.mName.C_Str(), parent, decompose(local)};
  // Assimp's matrices are floats: what differs by their rounding is a product T R S.
  if (!((affine(node.rest) - local).cwiseAbs().maxCoeff() <= 1e-5 * local.cwiseAbs().maxCoeff())) {
    node.matrix = local;
  }
  by_name_[node.name].push_back(index);
  character_.skeleton.nodes.push_back(std::move(node));
  source_.push_back(&source);
  for (unsigned c = 0; c < source.mNumChildren; ++c) add_nodes(*source.mChildren[c], index);
}

/// Nodes that Assimp's FBX reader has renamed from `name` because the name was taken: "name001" and so on.
std::vector<int> SceneReader::twins(const std::string& name) const {
  std::vector<int> found;
  for (int i = 1; i < 1000; ++i) {
    char number[8];
    std::snprintf(number, sizeof number, "%03d", i);
    const auto node = by_name_.find(name + number);
    if (node == by_name_.end()) break;
    if (!bone_names_.count(node->first)) found.push_back(node->second.front());
  }
  return found;
}

/// The node that a bone or a channel of this name means, or -1. Assimp refers by name alone, and a mesh
/// may have the name of a joint: a bone then means the node that carries no mesh.
int SceneReader::node_named(const std::string& name) {
  const auto [answer, is_new] = meant_.try_emplace(name, -1);
  if (!is_new) return answer->second;
  const auto named = by_name_.find(name);
  if (named == by_name_.end()) return -1;
  answer->second = named->second.front();
  if (!bone_names_.count(name)) return answer->second;

  const auto bare = [&](int n) { return source_[n]->mNumMeshes == 0; };
  std::vector<int> candidates = named->second;
  if (std::none_of(candidates.begin(), candidates.end(), bare)) {
    for (const int twin : twins(name)) {
      if (bare(twin)) candidates.push_back(twin);
    }
  }
  const auto joint = std::find_if(candidates.begin(), candidates.end(), bare);
  if (joint != candidates.end()) answer->second = *joint;
  if (candidates.size() > 1) {
    note(WarningCode::JointNameClash, name, std::int64_t(candidates.size()) - 1,
         "taken for the joint: node " + std::to_string(answer->second) + ", which carries no mesh");
  }
  return answer->second;
}

std::string SceneReader::part_name(const Instance& instance) const {
  const std::string own = instance.mesh->mName.C_Str();
  return own.empty() ? character_.skeleton.nodes[instance.node].name : own;
}

void SceneReader::add_materials() {
  for (unsigned m = 0; m < scene_.mNumMaterials; ++m) {
    const aiMaterial& source = *scene_.mMaterials[m];
    Material material{source.GetName().C_Str()};
    aiColor4D diffuse(1, 1, 1, 1);
    source.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
    float opacity = 1;
    // Exporters disagree on which end of it is transparent, and nobody ships an invisible character.
    if (source.Get(AI_MATKEY_OPACITY, opacity) != aiReturn_SUCCESS || !(opacity > 0)) opacity = 1;
    material.base_colour = {double(diffuse.r), double(diffuse.g), double(diffuse.b), double(opacity)};
    aiString texture;
    if (source.GetTexture(aiTextureType_DIFFUSE, 0, &texture) == aiReturn_SUCCESS) {
      const aiTexture* embedded = scene_.GetEmbeddedTexture(texture.C_Str());
      material.texture = embedded ? embedded->mFilename.C_Str() : texture.C_Str();
    }
    int two_sided = 0;
    source.Get(AI_MATKEY_TWOSIDED, two_sided);
    material.double_sided = two_sided != 0;
    character_.materials.push_back(std::move(material));
  }
}

bool has_faces(const aiMesh& mesh) {
  return mesh.mVertices && std::any_of(mesh.mFaces, mesh.mFaces + mesh.mNumFaces,
                                       [](const aiFace& face) { return face.mNumIndices >= 3; });
}

/// Every mesh at every node that shows it. A mesh with bones stands where they are, whatever node shows it:
/// it comes once.
std::vector<SceneReader::Instance> SceneReader::instances() {
  std::vector<Instance> instances;
  std::set<const aiMesh*> skinned;
  for (int n = 0; n < int(source_.size()); ++n) {
    for (unsigned m = 0; m < source_[n]->mNumMeshes; ++m) {
      const unsigned index = source_[n]->mMeshes[m];
      if (index >= scene_.mNumMeshes) continue;
      Instance instance{n, scene_.mMeshes[index], {}, {}};
      const aiMesh& mesh = *instance.mesh;
      for (unsigned b = 0; b < mesh.mNumBones; ++b) {
        const aiBone& bone = *mesh.mBones[b];
        if (node_named(bone.mName.C_Str()) >= 0) {
          instance.bones.push_back(int(b));
        } else {
          note(WarningCode::InfluencesOutOfRange, part_name(instance), bone.mNumWeights,
               std::string("there is no node '") + bone.mName.C_Str() + "'");
        }
      }
      const auto flat = std::count_if(mesh.mFaces, mesh.mFaces + mesh.mNumFaces,
                                      [](const aiFace& face) { return face.mNumIndices < 3; });
      note(WarningCode::NotASkinFeature, part_name(instance), flat, "points and lines");
      if (!has_faces(mesh)) continue;
      if (!instance.bones.empty() && !skinned.insert(&mesh).second) continue;
      instances.push_back(std::move(instance));
    }
  }
  return instances;
}

// Skins first: rigid meshes are then placed by joints whose bind is known.
void SceneReader::bind(std::vector<Instance>& instances) {
  std::vector<Joint> joints;
  for (Instance& instance : instances) {
    if (instance.bones.empty()) continue;
    joints.clear();
    for (const int b : instance.bones) {
      const aiBone& bone = *instance.mesh->mBones[b];
      joints.push_back({node_named(bone.mName.C_Str()), affine_of(bone.mOffsetMatrix)});
    }
    instance.skin = add_skin(character_.skeleton, joints);
  }
  for (Instance& instance : instances) {
    if (!instance.bones.empty()) continue;
    joints = {{instance.node, identity()}};
    instance.skin = add_skin(character_.skeleton, joints);
  }
}

AttributeLayout layout_of(const aiMesh& mesh) {
  return {mesh.HasNormals(), mesh.HasTangentsAndBitangents(), int(mesh.GetNumUVChannels()),
          int(mesh.GetNumColorChannels())};
}

void SceneReader::add_meshes() {
  // "Incomplete" says that the meshes, if any, are Assimp's own drawing of the bones.
  const bool made_up = scene_.mFlags & AI_SCENE_FLAGS_INCOMPLETE;
  std::vector<Instance> parts = made_up ? std::vector<Instance>() : instances();
  if (parts.empty()) {
    throw Error(Fault::Input, path_ + ": no faces: it holds no polygons: export it with its mesh");
  }
  if (std::all_of(parts.begin(), parts.end(), [](const Instance& part) { return part.bones.empty(); })) {
    throw Error(Fault::Input,
                path_ + ": no skin: no vertex is bound to a joint: export it with its skeleton");
  }
  bind(parts);
  Eigen::Index wedges = 0;
  AttributeLayout& layout = surface_.layout;
  for (const Instance& part : parts) {
    layout = joined(layout, layout_of(*part.mesh));
    wedges += part.mesh->mNumVertices;
  }
  surface_.attributes = default_attributes(layout).replicate(wedges, 1);
  for (const Instance& part : parts) add_part(part);
  // Either every vertex has a list or there is none at all.
  const auto none = [](const auto& offsets) { return offsets.empty(); };
  surface_.morphs.resize(surface_.position.size());
  surface_.normal_morphs.resize(surface_.wedges.size());
  if (std::all_of(surface_.morphs.begin(), surface_.morphs.end(), none)) surface_.morphs.clear();
  if (std::all_of(surface_.normal_morphs.begin(), surface_.normal_morphs.end(), none)) {
    surface_.normal_morphs.clear();
  }
}

void SceneReader::add_part(const Instance& instance) {
  const int first = int(surface_.position.size());
  const int part = int(character_.parts.size());
  const int material =
      instance.mesh->mMaterialIndex < scene_.mNumMaterials ? int(instance.mesh->mMaterialIndex) : -1;
  character_.parts.push_back({part_name(instance), instance.node, material, layout_of(*instance.mesh)});
  add_vertices(instance, part);
  add_influences(instance, first);
  add_faces(instance, first);
  add_morphs(instance, first);
}

void SceneReader::add_vertices(const Instance& instance, int part) {
  const aiMesh& mesh = *instance.mesh;
  const AttributeLayout& layout = surface_.layout;
  const AttributeLayout has = layout_of(mesh);
  const Mat3 linear = instance.skin.to_rest.leftCols<3>();
  const Mat3 across = invertible(instance.skin.to_rest) ? Mat3(linear.inverse().transpose()) : linear;
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const int v = int(surface_.position.size());
    surface_.position.push_back(transform(instance.skin.to_rest, vec3(mesh.mVertices[i]) * convention_.unit));
    surface_.wedges.push_back({v, part});
    auto row = surface_.attributes.row(v);  // a wedge has the index of its vertex
    if (has.normal) row.segment<3>(layout.normal_at()) = (across * vec3(mesh.mNormals[i])).normalized();
    if (has.tangent) {
      const Vec3 t = linear * vec3(mesh.mTangents[i]);
      const Vec3 n = across * vec3(mesh.mNormals[i]);
      const Vec3 b = linear * vec3(mesh.mBitangents[i]);
      row.segment<3>(layout.tangent_at()) = t.normalized();
      row[layout.tangent_at() + 3] = n.cross(t).dot(b) < 0 ? -1 : 1;
    }
    for (int set = 0; set < has.uv_sets; ++set) {
      const Vec3 uv = vec3(mesh.mTextureCoords[set][i]);
      row.segment<2>(layout.uv_at(set)) << uv.x(), 1 - uv.y();  // Assimp's v grows upwards, glTF's down
    }
    for (int set = 0; set < has.colour_sets; ++set) {
      const aiColor4D& c = mesh.mColors[set][i];
      row.segment<4>(layout.colour_at(set)) << double(c.r), double(c.g), double(c.b), double(c.a);
    }
  }
}

void SceneReader::add_influences(const Instance& instance, int first_vertex) {
  const aiMesh& mesh = *instance.mesh;
  surface_.influences.resize(surface_.position.size());
  const auto own = std::span(surface_.influences).subspan(size_t(first_vertex));
  if (instance.bones.empty()) {
    for (Influences& influences : own) influences = {{instance.skin.joint.front(), 1}};
    return;
  }
  std::int64_t astray = 0;
  for (size_t b = 0; b < instance.bones.size(); ++b) {
    const aiBone& bone = *mesh.mBones[instance.bones[b]];
    for (unsigned i = 0; i < bone.mNumWeights; ++i) {
      const aiVertexWeight& weight = bone.mWeights[i];
      if (weight.mVertexId >= own.size()) {
        ++astray;
      } else if (weight.mWeight != 0) {
        own[weight.mVertexId].push_back({instance.skin.joint[b], double(weight.mWeight)});
      }
    }
  }
  note(WarningCode::InfluencesOutOfRange, part_name(instance), astray,
       "weights of vertices that are not there");
}

void SceneReader::add_faces(const Instance& instance, int first_wedge) {
  const aiMesh& mesh = *instance.mesh;
  const bool mirrored = instance.skin.to_rest.leftCols<3>().determinant() < 0;
  std::vector<int> corners;
  std::int64_t out_of_range = 0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const std::span face(mesh.mFaces[f].mIndices, mesh.mFaces[f].mNumIndices);
    if (face.size() < 3) continue;
    if (std::any_of(face.begin(), face.end(), [&](unsigned i) { return i >= mesh.mNumVertices; })) {
      ++out_of_range;
      continue;
    }
    corners.assign(face.begin(), face.end());
    for (int& corner : corners) corner += first_wedge;
    if (mirrored) std::reverse(corners.begin(), corners.end());
    surface_.add_face(corners);
  }
  note(WarningCode::FaceOutOfRange, part_name(instance), out_of_range);
}

int SceneReader::morph(int node, const std::string& name) {
  auto& morphs = character_.morphs;
  const auto found = std::find_if(morphs.begin(), morphs.end(),
                                  [&](const Morph& m) { return m.node == node && m.name == name; });
  if (found != morphs.end()) return int(found - morphs.begin());
  // Assimp gives the weight 1 to targets of weight 0, so that no weight of it can be believed.
  morphs.push_back({name, node, 0});
  return int(morphs.size()) - 1;
}

/// The largest coordinate of the mesh times the rounding of two floats. Assimp keeps a shape as base +
/// offset: smaller differences are what that sum has lost, not what the artist has made.
double rounding(const aiMesh& mesh) {
  float size = 0;
  for (const aiVector3D& v : std::span(mesh.mVertices, mesh.mNumVertices)) {
    size = std::max({size, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  }
  return double(size) * double(std::numeric_limits<float>::epsilon());
}

/// Assimp gives whole shapes, and cuts a mesh by materials: the shapes of a name at a node are one morph.
void SceneReader::add_morphs(const Instance& instance, int first_vertex) {
  const aiMesh& mesh = *instance.mesh;
  const Mat3 linear = instance.skin.to_rest.leftCols<3>();
  const Mat3 across = invertible(instance.skin.to_rest) ? Mat3(linear.inverse().transpose()) : linear;
  const double least = rounding(mesh), least_turn = 2 * double(std::numeric_limits<float>::epsilon());
  std::map<std::string, int> seen;
  for (unsigned a = 0; a < mesh.mNumAnimMeshes; ++a) {
    const aiAnimMesh& shape = *mesh.mAnimMeshes[a];
    if (!shape.HasPositions() || shape.mNumVertices != mesh.mNumVertices) continue;
    std::string name = shape.mName.length ? shape.mName.C_Str() : "morph";
    if (const int nth = seen[name]++; nth > 0) name += " " + std::to_string(nth + 1);
    const int m = morph(instance.node, name);
    surface_.morphs.resize(surface_.position.size());
    surface_.normal_morphs.resize(surface_.wedges.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const int v = first_vertex + int(i);
      const Vec3 offset = vec3(shape.mVertices[i]) - vec3(mesh.mVertices[i]);
      if (!(offset.cwiseAbs().maxCoeff() <= least)) {  // not a number is kept, for `repair` to find
        surface_.morphs[v].push_back({m, linear * offset * convention_.unit});
      }
      if (!shape.HasNormals() || !mesh.HasNormals()) continue;
      const Vec3 normal = (across * vec3(shape.mNormals[i])).normalized();
      const Vec3 delta = normal - (across * vec3(mesh.mNormals[i])).normalized();
      if (!(delta.cwiseAbs().maxCoeff() <= least_turn)) surface_.normal_morphs[v].push_back({m, delta});
    }
  }
}

void SceneReader::add_clips() {
  const std::string unnamed = std::filesystem::path(path_).stem().string();
  for (unsigned i = 0; i < scene_.mNumAnimations; ++i) {
    const aiAnimation& animation = *scene_.mAnimations[i];
    character_.clips.push_back(clip(animation, animation.mName.length ? animation.mName.C_Str() : unnamed));
  }
}

template <class Keys>
double first_time(const Keys* keys, unsigned count, double earliest) {
  for (unsigned k = 0; k < count; ++k) earliest = std::min(earliest, keys[k].mTime);
  return earliest;
}

/// Where the clip begins, ticks: 0, or its first key before that.
double beginning(const aiAnimation& animation) {
  double first = 0;
  for (unsigned c = 0; c < animation.mNumChannels; ++c) {
    const aiNodeAnim& channel = *animation.mChannels[c];
    first = first_time(channel.mPositionKeys, channel.mNumPositionKeys, first);
    first = first_time(channel.mRotationKeys, channel.mNumRotationKeys, first);
    first = first_time(channel.mScalingKeys, channel.mNumScalingKeys, first);
  }
  for (unsigned c = 0; c < animation.mNumMorphMeshChannels; ++c) {
    first =
        first_time(animation.mMorphMeshChannels[c]->mKeys, animation.mMorphMeshChannels[c]->mNumKeys, first);
  }
  return first;
}

template <class Key, class Value>
void add_channel(Clip& clip, int node, Path path, std::span<Key> keys, const Ticks& ticks, Value value) {
  if (keys.empty()) return;
  Channel channel{node, path, Interpolation::Linear, {}, Rows(keys.size(), path == Path::Rotation ? 4 : 3)};
  for (size_t k = 0; k < keys.size(); ++k) {
    channel.times.push_back(ticks.seconds(keys[k].mTime));
    channel.values.row(Eigen::Index(k)) = value(keys[k].mValue).transpose();
  }
  clip.channels.push_back(std::move(channel));
}

Clip SceneReader::clip(const aiAnimation& animation, const std::string& name) {
  Clip clip{name, {}};
  const double per_second = animation.mTicksPerSecond;
  const Ticks ticks{beginning(animation), per_second > 0 ? per_second : convention_.ticks_per_second};
  const auto length = [&](const aiVector3D& v) { return Vec3(vec3(v) * convention_.unit); };
  std::int64_t unbound = 0;
  for (unsigned c = 0; c < animation.mNumChannels; ++c) {
    const aiNodeAnim& keys = *animation.mChannels[c];
    const int node = node_named(keys.mNodeName.C_Str());
    if (node < 0) {
      ++unbound;
      continue;
    }
    const Affine rest = affine(character_.skeleton.nodes[node].rest);
    const auto place = [&](const aiVector3D& v) {
      if (!convention_.moves_turned || !invertible(rest)) return length(v);
      return Vec3(rest.col(3) + transform(inverse(rest), length(v)));
    };
    add_channel(clip, node, Path::Translation, std::span(keys.mPositionKeys, keys.mNumPositionKeys), ticks,
                place);
    add_channel(clip, node, Path::Rotation, std::span(keys.mRotationKeys, keys.mNumRotationKeys), ticks,
                quat);
    add_channel(clip, node, Path::Scale, std::span(keys.mScalingKeys, keys.mNumScalingKeys), ticks, vec3);
  }
  for (unsigned c = 0; c < animation.mNumMorphMeshChannels; ++c) {
    const aiMeshMorphAnim& keys = *animation.mMorphMeshChannels[c];
    const std::string target = keys.mName.C_Str();
    const int node = node_named(target.substr(0, target.rfind('*')));  // FBX: "node*mesh"
    if (node < 0) {
      ++unbound;
    } else {
      clip.channels.push_back(morph_channel(node, std::span(keys.mKeys, keys.mNumKeys), ticks));
    }
  }
  note(WarningCode::ClipChannelsUnbound, name, unbound, "no node of the file has their name");
  return clip;
}

/// Every key names only some of the targets, so that each target has times of its own: all of them are
/// looked up, linearly, at the times of all.
Channel SceneReader::morph_channel(int node, std::span<const aiMeshMorphKey> keys, const Ticks& ticks) const {
  std::vector<std::map<double, double>> weight_at(size_t(std::count_if(
      character_.morphs.begin(), character_.morphs.end(), [&](const Morph& m) { return m.node == node; })));
  Channel channel{node, Path::MorphWeights, Interpolation::Linear, {}, {}};
  for (const aiMeshMorphKey& key : keys) {
    channel.times.push_back(ticks.seconds(key.mTime));
    for (unsigned i = 0; i < key.mNumValuesAndWeights; ++i) {
      if (key.mValues[i] >= 4096) continue;  // no mesh has so many; an index that lies allocates nothing
      if (key.mValues[i] >= weight_at.size()) weight_at.resize(key.mValues[i] + 1);
      weight_at[key.mValues[i]][channel.times.back()] = key.mWeights[i];
    }
  }
  channel.values = Rows::Zero(Eigen::Index(keys.size()), Eigen::Index(weight_at.size()));
  for (size_t t = 0; t < weight_at.size(); ++t) {
    for (size_t k = 0; k < keys.size() && !weight_at[t].empty(); ++k) {
      const double time = channel.times[k];
      const auto after = weight_at[t].lower_bound(time);
      const auto before = after == weight_at[t].begin() ? after : std::prev(after);
      double& weight = channel.values(Eigen::Index(k), Eigen::Index(t));
      if (after == weight_at[t].end()) {
        weight = before->second;
      } else if (after == before || after->first == time) {
        weight = after->second;
      } else {
        const double part = (time - before->first) / (after->first - before->first);
        weight = before->second + part * (after->second - before->second);
      }
    }
  }
  return channel;
}

}  // namespace

Imported read_scene(const aiScene& scene, const std::string& path, Need need) {
  return SceneReader(scene, path).read(need);
}

}  // namespace skinlod
