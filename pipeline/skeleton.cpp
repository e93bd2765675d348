// SPDX-License-Identifier: MIT
#include "pipeline/skeleton.h"

#include <algorithm>

#include "pipeline/error.h"
#include "pipeline/rotation.h"

namespace skinlod {
namespace {

// Unit vectors along the columns of `m`; a column without length gets one at right angles to the others.
Mat3 directions(const Mat3& m, const Vec3& lengths) {
  if (lengths.isZero(0)) return Mat3::Identity();
  Mat3 r = Mat3::Zero();
  int longest = 0;
  lengths.maxCoeff(&longest);
  for (int i = 0; i < 3; ++i) {
    if (lengths[i] > 0) r.col(i) = m.col(i) / lengths[i];
  }
  const int j = (longest + 1) % 3, k = (longest + 2) % 3;
  if (lengths[j] == 0 && lengths[k] == 0) {
    int least = 0;
    r.col(longest).cwiseAbs().minCoeff(&least);
    r.col(j) = r.col(longest).cross(Vec3::Unit(least)).normalized();
  }
  if (lengths[k] == 0) {
    r.col(k) = r.col(longest).cross(r.col(j)).normalized();
  } else if (lengths[j] == 0) {
    r.col(j) = r.col(k).cross(r.col(longest)).normalized();
  }
  return r;
}

// The distance of a node from its root.
std::vector<int> depths(const Skeleton& skeleton) {
  std::vector<int> depth(skeleton.nodes.size(), 0);
  for (const int n : parents_first(skeleton)) {
    if (const int parent = skeleton.nodes[n].parent; parent >= 0) depth[n] = depth[parent] + 1;
  }
  return depth;
}

Affine rest_local(const Node& node) { return node.matrix ? *node.matrix : affine(node.rest); }

// A node's place in rest space: where its first joint is bound, else below its parent as in the rest pose.
Affine rest_place(const Skeleton& skeleton, int node) {
  std::vector<const Joint*> bound(skeleton.nodes.size(), nullptr);
  for (const Joint& joint : skeleton.joints) {
    if (!bound[joint.node] && invertible(joint.inverse_bind)) bound[joint.node] = &joint;
  }
  std::vector<int> path;  // up to what is bound, or to the root
  for (; node >= 0 && !bound[node]; node = skeleton.nodes[node].parent) path.push_back(node);
  Affine place;
  if (node >= 0) {
    place = inverse(bound[node]->inverse_bind);
  } else {
    place = rest_local(skeleton.nodes[path.back()]);
    path.pop_back();
  }
  for (auto n = path.rbegin(); n != path.rend(); ++n) place = compose(place, rest_local(skeleton.nodes[*n]));
  return place;
}

Affine without_zero_scale(const Affine& a) {
  Transform t = decompose(a);
  if (invertible(a) && t.scale.cwiseAbs().minCoeff() >= 1e-6) return a;
  for (double& scale : t.scale) {
    if (std::abs(scale) < 1e-6) scale = 1;
  }
  const Affine upright = affine(t);
  return invertible(upright) ? upright : identity();
}

// Rest space from the skin's bind space.
Affine to_rest(const Skeleton& skeleton, std::span<const Joint> skin) {
  const std::vector<int> depth = depths(skeleton);
  std::vector<bool> bound(skeleton.nodes.size(), false);
  for (const Joint& joint : skeleton.joints) bound[joint.node] = true;
  const Joint* best = nullptr;
  std::pair<bool, int> rank;  // free, depth: the least places the skin, the first of equals
  for (const Joint& joint : skin) {
    const std::pair<bool, int> its{!bound[joint.node], depth[joint.node]};
    if (invertible(joint.inverse_bind) && (!best || its < rank)) best = &joint, rank = its;
  }
  if (!best) return identity();
  return compose(without_zero_scale(rest_place(skeleton, best->node)), best->inverse_bind);
}

// The joint of the skeleton that is `joint`, which may be a new one. `at` has the joints of each node.
int shared_joint(Skeleton& skeleton, const Joint& joint, std::vector<std::vector<int>>& at) {
  const double tolerance = 1e-5 * joint.inverse_bind.cwiseAbs().maxCoeff();
  for (const int b : at[joint.node]) {
    const Affine difference = skeleton.joints[b].inverse_bind - joint.inverse_bind;
    if (difference.cwiseAbs().maxCoeff() <= tolerance) return b;
  }
  at[joint.node].push_back(int(skeleton.joints.size()));
  skeleton.joints.push_back(joint);
  return at[joint.node].back();
}

}  // namespace

Affine affine(const Transform& transform) {
  Affine a;
  a << matrix(normalised(transform.rotation)) * transform.scale.asDiagonal(), transform.translation;
  return a;
}

Transform decompose(const Affine& a) {
  const Mat3 m = a.leftCols<3>();
  Transform t;
  t.translation = a.col(3);
  t.scale = m.colwise().norm().transpose();
  Mat3 r = directions(m, t.scale);
  if (r.determinant() < 0) r.col(0) *= -1, t.scale.x() *= -1;
  t.rotation = quaternion(r);
  return t;
}

std::vector<int> parents_first(const Skeleton& skeleton) {
  const int count = int(skeleton.nodes.size());
  enum class Mark : char { New, Climbed, Placed };
  std::vector<Mark> mark(count, Mark::New);
  std::vector<int> order, path;
  order.reserve(count);
  for (int start = 0; start < count; ++start) {
    path.clear();
    for (int n = start; n >= 0 && mark[n] != Mark::Placed; n = skeleton.nodes[n].parent) {
      const Node& node = skeleton.nodes[n];
      if (mark[n] == Mark::Climbed || node.parent < -1 || node.parent >= count) {
        throw Error{Fault::Input,
                    "node '" + node.name + "': " +
                        (mark[n] == Mark::Climbed ? "is its own ancestor" : "its parent is not in the file") +
                        ": export the skeleton again"};
      }
      mark[n] = Mark::Climbed;
      path.push_back(n);
    }
    for (auto n = path.rbegin(); n != path.rend(); ++n) mark[*n] = Mark::Placed, order.push_back(*n);
  }
  return order;
}

std::vector<std::string> node_labels(const Skeleton& skeleton) {
  std::vector<std::string> labels(skeleton.nodes.size());
  int place = 0;
  for (const int n : parents_first(skeleton)) {
    const std::string& name = skeleton.nodes[n].name;
    labels[n] = name.empty() ? "node " + std::to_string(place) : name;
    ++place;
  }
  return labels;
}

std::vector<std::string> joint_labels(const Skeleton& skeleton) {
  const std::vector<std::string> nodes = node_labels(skeleton);
  std::vector<std::string> labels;
  for (const Joint& joint : skeleton.joints) labels.push_back(joint.node < 0 ? "" : nodes[joint.node]);
  return labels;
}

std::vector<Affine> rest_locals(const Skeleton& skeleton) {
  std::vector<Affine> locals;
  locals.reserve(skeleton.nodes.size());
  for (const Node& node : skeleton.nodes) locals.push_back(rest_local(node));
  return locals;
}

std::vector<Affine> globals(const Skeleton& skeleton, std::span<const Affine> locals) {
  std::vector<Affine> global(locals.begin(), locals.end());
  for (const int n : parents_first(skeleton)) {
    if (const int parent = skeleton.nodes[n].parent; parent >= 0) {
      global[n] = compose(global[parent], global[n]);
    }
  }
  return global;
}

Palette palette(const Skeleton& skeleton, std::span<const Affine> globals) {
  Palette palette;
  palette.reserve(skeleton.joints.size());
  for (const Joint& joint : skeleton.joints)
    palette.push_back(compose(globals[joint.node], joint.inverse_bind));
  return palette;
}

BoundSkin add_skin(Skeleton& skeleton, std::span<const Joint> skin) {
  BoundSkin bound;
  bound.to_rest = to_rest(skeleton, skin);
  const Affine from_rest = inverse(bound.to_rest);
  std::vector<std::vector<int>> at(skeleton.nodes.size());
  for (size_t b = 0; b < skeleton.joints.size(); ++b) at[skeleton.joints[b].node].push_back(int(b));
  for (const Joint& joint : skin) {
    bound.joint.push_back(shared_joint(skeleton, {joint.node, compose(joint.inverse_bind, from_rest)}, at));
  }
  return bound;
}

}  // namespace skinlod
