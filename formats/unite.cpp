// SPDX-License-Identifier: MIT
#include "formats/unite.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "formats/gltf_space.h"
#include "formats/gltf_unite.h"
#include "formats/import_any.h"
#include "pipeline/error.h"

namespace skinlod {
namespace {

// How far two rest transforms of one node may be apart, against the largest number in them.
constexpr double kRounding = 1e-4;

bool same(const Affine& a, const Affine& b) {
  return (a - b).cwiseAbs().maxCoeff() <= kRounding * a.cwiseAbs().maxCoeff();
}

bool same(const Channel& a, const Channel& b) {
  return a.times == b.times && a.values.rows() == b.values.rows() && a.values.cols() == b.values.cols() &&
         a.values.isApprox(b.values, kRounding);
}

std::vector<char> carriers(const Character& character) {
  std::vector<char> carries(character.skeleton.nodes.size(), 0);
  for (const Part& part : character.parts) {
    if (part.node >= 0) carries[part.node] = 1;
  }
  return carries;
}

// The joints of skins, and all that they hang from: what must be the same in every file. A joint on a node
// that carries a mesh is there for a rigid mesh.
std::vector<char> bones(const Character& character) {
  const Skeleton& skeleton = character.skeleton;
  const std::vector<char> carries = carriers(character);
  std::vector<char> is_bone(skeleton.nodes.size(), 0);
  for (const Joint& joint : skeleton.joints) {
    if (carries[joint.node]) continue;
    for (int n = joint.node; n >= 0 && !is_bone[n]; n = skeleton.nodes[n].parent) is_bone[n] = 1;
  }
  return is_bone;
}

class Uniting {
 public:
  Uniting(Imported& whole, Imported& other, const std::string& name)
      : whole_(whole), other_(other), ours_(whole.character), theirs_(other.character), name_(name) {}

  void unite() {
    add_nodes();
    add_joints();
    add_materials();
    add_parts();
    add_geometry();
    for (Clip& clip : theirs_.clips) add_clip(std::move(clip));
    for (Warning& warning : other_.warnings) warn(whole_.warnings, std::move(warning));
    whole_.files_read.insert(whole_.files_read.end(), other_.files_read.begin(), other_.files_read.end());
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw Error(Fault::Input, name_ + ": " + message);
  }

  std::string name_of(int our_node) const {
    return our_node < 0 ? "no node" : "'" + ours_.skeleton.nodes[our_node].name + "'";
  }

  void add_nodes() {
    const std::vector<Affine> rest = rest_locals(ours_.skeleton), their_rest = rest_locals(theirs_.skeleton);
    const std::vector<char> is_bone = bones(theirs_), carries = carriers(theirs_);
    std::multimap<std::string, int> named;
    for (size_t n = 0; n < rest.size(); ++n) named.emplace(ours_.skeleton.nodes[n].name, int(n));
    node_.assign(their_rest.size(), -1);
    bool any = false;
    for (const int n : parents_first(theirs_.skeleton)) {
      Node node = theirs_.skeleton.nodes[n];
      if (node.parent >= 0) node.parent = node_[node.parent];
      const auto [begin, end] = named.equal_range(node.name);
      const auto found = std::find_if(begin, end, [&](const auto& its) {
        return ours_.skeleton.nodes[its.second].parent == node.parent &&
               same(rest[its.second], their_rest[n]);
      });
      const bool may_be_shared = !node.name.empty() && (is_bone[n] || !carries[n]);
      if (may_be_shared && found != end) {
        node_[n] = found->second;
        any |= is_bone[n];
        continue;
      }
      if (may_be_shared && is_bone[n] && begin != end) refuse(node, begin->second);
      node_[n] = int(ours_.skeleton.nodes.size());
      ours_.skeleton.nodes.push_back(std::move(node));
    }
    if (!any)
      fail("none of its joints is in the files before it: give parts of one character, with its joint names");
    carries_ = carriers(ours_);
  }

  [[noreturn]] void refuse(const Node& node, int our_node) const {
    const int parent = ours_.skeleton.nodes[our_node].parent;
    if (parent != node.parent) {
      fail("joint '" + node.name + "': hangs from " + name_of(node.parent) + ", and from " + name_of(parent) +
           " in the files before it: export all from one skeleton");
    }
    fail("joint '" + node.name +
         "': rests elsewhere than in the files before it: export all in the same rest pose");
  }

  void add_joints() {
    std::vector<Joint> skin = theirs_.skeleton.joints;
    for (Joint& joint : skin) joint.node = node_[joint.node];
    bound_ = add_skin(ours_.skeleton, skin);
  }

  // A node carries one mesh; another one for it hangs on a node of its own below.
  int carrier(int their_node) {
    const auto [place, fresh] = carrier_.try_emplace(their_node, -1);
    int& node = place->second;
    if (!fresh) return node;
    node = node_[their_node];
    if (node >= int(carries_.size()) || !carries_[node]) return node;
    std::string name = ours_.skeleton.nodes[node].name + "." + stem(name_);
    ours_.skeleton.nodes.push_back({.name = std::move(name), .parent = node});
    return node = int(ours_.skeleton.nodes.size()) - 1;
  }

  void add_materials() {
    std::shared_ptr<const GltfDocument> with_theirs;
    if (whole_.document) {
      std::tie(with_theirs, material_) = with_materials(*whole_.document, other_, whole_.warnings);
      whole_.document = with_theirs;
    } else {
      warn(whole_.warnings, {WarningCode::MaterialPropertyLost, name_,
                             other_.document ? std::int64_t(theirs_.materials.size()) : 0,
                             "materials with more than colour and texture: the first file is no glTF"});
      for (size_t m = 0; m < theirs_.materials.size(); ++m)
        material_.push_back(int(ours_.materials.size() + m));
    }
    for (size_t m = 0; m < theirs_.materials.size(); ++m) {
      if (material_[m] == int(ours_.materials.size())) ours_.materials.push_back(theirs_.materials[m]);
    }
  }

  void add_parts() {
    first_part_ = int(ours_.parts.size()), first_morph_ = int(ours_.morphs.size());
    for (Part& part : theirs_.parts) {
      if (part.node >= 0) part.node = carrier(part.node);
      if (part.material >= 0) part.material = material_[part.material];
      ours_.parts.push_back(std::move(part));
    }
    for (Morph& morph : theirs_.morphs) {
      if (morph.node >= 0) morph.node = carrier(morph.node);
      ours_.morphs.push_back(std::move(morph));
    }
  }

  void add_geometry() {
    Surface &s = ours_.surface, &theirs = theirs_.surface;
    const ChangeOfSpace to_rest(bound_.to_rest);
    const int first_vertex = int(s.position.size()), first_wedge = int(s.wedges.size());
    add_morphs(s.morphs, theirs.morphs, s.position.size(), theirs.position.size(), to_rest.along);
    add_morphs(s.normal_morphs, theirs.normal_morphs, s.wedges.size(), theirs.wedges.size(), to_rest.normal);
    for (const Vec3& x : theirs.position) s.position.push_back(transform(to_rest.map, x));
    for (Influences& influences : theirs.influences) {
      for (Influence& i : influences) {
        if (i.joint >= 0 && i.joint < int(bound_.joint.size())) i.joint = bound_.joint[i.joint];
      }
      std::stable_sort(influences.begin(), influences.end(),
                       [](const Influence& a, const Influence& b) { return a.joint < b.joint; });
      s.influences.push_back(std::move(influences));
    }
    for (const Wedge& w : theirs.wedges) s.wedges.push_back({first_vertex + w.vertex, first_part_ + w.part});
    for (int f = 0; f < theirs.face_count(); ++f) {
      std::vector<int> face;
      for (const int w : theirs.face(f)) face.push_back(w < 0 ? w : first_wedge + w);
      if (to_rest.mirrors) std::reverse(face.begin(), face.end());
      s.add_face(face);
    }
    const AttributeLayout layout = joined(s.layout, theirs.layout);
    turn(theirs.attributes, theirs.layout, to_rest);
    Rows rows(s.attributes.rows() + theirs.attributes.rows(), layout.columns());
    rows << widened(s.attributes, s.layout, layout), widened(theirs.attributes, theirs.layout, layout);
    s.attributes = std::move(rows), s.layout = layout;
  }

  static void turn(Rows& attributes, const AttributeLayout& layout, const ChangeOfSpace& to_rest) {
    for (auto row : attributes.rowwise()) {
      const auto turned = [&](int column, const Mat3& by) {
        row.segment<3>(column) = unit(by * row.segment<3>(column).transpose()).transpose();
      };
      if (layout.normal) turned(layout.normal_at(), to_rest.normal);
      if (layout.tangent) turned(layout.tangent_at(), to_rest.along);
      if (layout.tangent && to_rest.mirrors) row[layout.tangent_at() + 3] *= -1;
    }
  }

  // Either list may be empty, which is none at all.
  void add_morphs(std::vector<MorphOffsets>& list, std::vector<MorphOffsets>& theirs, size_t count,
                  size_t their_count, const Mat3& turn) const {
    if (list.empty() && theirs.empty()) return;
    list.resize(count), theirs.resize(their_count);
    for (MorphOffsets& offsets : theirs) {
      for (auto& [morph, delta] : offsets) morph += first_morph_, delta = (turn * delta).eval();
      list.push_back(std::move(offsets));
    }
  }

  void add_clip(Clip clip) {
    for (Channel& channel : clip.channels)
      channel.node = channel.path == Path::MorphWeights ? carrier(channel.node) : node_[channel.node];
    const auto taken = std::find_if(ours_.clips.begin(), ours_.clips.end(),
                                    [&](const Clip& its) { return its.name == clip.name; });
    if (taken != ours_.clips.end()) {
      std::int64_t differ = 0;
      std::erase_if(clip.channels, [&](const Channel& channel) {
        const auto twin = std::find_if(
            taken->channels.begin(), taken->channels.end(),
            [&](const Channel& its) { return its.node == channel.node && its.path == channel.path; });
        if (twin == taken->channels.end()) return false;
        differ += !same(*twin, channel);
        return true;
      });
      warn(whole_.warnings, {WarningCode::ClipChannelsTwice, clip.name, differ,
                             "other keys than in the files before " + name_ + ", left out"});
      if (clip.channels.empty()) return;
      clip.name = free_clip_name(ours_, clip.name, stem(name_));
    }
    ours_.clips.push_back(std::move(clip));
  }

  Imported &whole_, &other_;
  Character &ours_, &theirs_;
  const std::string& name_;
  std::vector<int> node_, material_;  // ours, per one of theirs
  std::vector<char> carries_;         // per node of ours, before the parts are added
  std::map<int, int> carrier_;
  BoundSkin bound_;
  int first_part_ = 0, first_morph_ = 0;
};

}  // namespace

void unite(Imported& whole, Imported other, const std::string& name) { Uniting(whole, other, name).unite(); }

}  // namespace skinlod
