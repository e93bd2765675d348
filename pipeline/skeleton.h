// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/linalg.h"

namespace skinlod {

/// A unit quaternion x, y, z, w (the order of glTF).
using Quat = Vec4;

/// Translation, rotation and scale, applied as T R S.
struct Transform {
  Vec3 translation = Vec3::Zero();
  Quat rotation = Quat(0, 0, 0, 1);
  Vec3 scale = Vec3::Ones();
};

/// T R S as one map. The rotation need not be of unit length; it is divided by its length.
Affine affine(const Transform& transform);

/// The transform with the column lengths of `a` as its scale, x negative where `a` mirrors, and the rotation
/// of its columns. Exact where `a` has no shear; close to `a` otherwise.
Transform decompose(const Affine& a);

/// A node of the file's hierarchy. Clips move nodes; joints are nodes that vertices follow.
struct Node {
  std::string name;
  int parent = -1;
  Transform rest = {};
  std::optional<Affine> matrix =
      {};  // a rest matrix that is no product T R S; used until a clip moves the node
};

/// A node together with the map from rest space into the node's own space. Vertices refer to joints.
/// One node can be two joints, where a file binds it twice in different places.
struct Joint {
  int node = -1;
  Affine inverse_bind = identity();
};

/// `nodes` may stand in any order but hold no circle; see `parents_first`.
struct Skeleton {
  std::vector<Node> nodes;
  std::vector<Joint> joints;
};

/// The nodes' indices, every parent before its children.
/// Throws Error{Input} where a parent is out of range or nodes hang in a circle.
std::vector<int> parents_first(const Skeleton& skeleton);

/// What each node is called: its name, or, where it has none, "node 7" by its place in `parents_first`, which
/// files that keep the order of the nodes keep.
std::vector<std::string> node_labels(const Skeleton& skeleton);

/// The same of each joint's node; nothing for a joint without one.
std::vector<std::string> joint_labels(const Skeleton& skeleton);

/// The local matrices of the rest pose, one per node.
std::vector<Affine> rest_locals(const Skeleton& skeleton);

/// Each node's map into world space, from the nodes' maps into their parents.
std::vector<Affine> globals(const Skeleton& skeleton, std::span<const Affine> locals);

/// One matrix per joint: world from rest space, T_b = global(node) x inverse bind.
using Palette = std::vector<Affine>;
Palette palette(const Skeleton& skeleton, std::span<const Affine> globals);

/// A skin as it stands in the skeleton.
struct BoundSkin {
  Affine to_rest = identity();  // rest space from the space of the file's bind matrices
  std::vector<int> joint;       // the skeleton's joint of each of the skin's joints
};

/// Adds a skin's joints to the skeleton. Every file binds in a space of its own (centimetres, another axis,
/// a rigid prop's own origin); all vertices of a character stand in one *rest space*, in which the identity
/// palette shows the whole character in one piece, in world units: the space in which the joint nearest to
/// the root stands where the rest pose has it. Positions must be taken through `to_rest`. A joint that is
/// there already (same node, same bind within 1e-5 of its size) is shared.
/// A rigid mesh on a node is a skin of one joint with the identity as its bind.
///
/// A later skin is put where its joints already stand in rest space: a joint on a node that is bound already
/// goes before the others as the one to place the skin by, and a node below a bound one hangs from it by the
/// rest pose. So a helmet stays on the head although the file binds in another pose than it rests in. Add
/// the skins before the rigid meshes, so that these hang on the skins and not the skins on them.
/// Scales below 1e-6 at that place (a prop hidden in the rest pose) count as 1, since rest space must be one
/// that can be left again; where all binds are singular, `to_rest` is the identity.
BoundSkin add_skin(Skeleton& skeleton, std::span<const Joint> skin);

}  // namespace skinlod
