// SPDX-License-Identifier: MIT
#include "tests/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace skinlod {
namespace {

// Every vertex with one wedge and no attributes, following joint 0.
Surface bare(std::vector<Vec3> position) {
  Surface s;
  s.position = std::move(position);
  s.influences.assign(s.position.size(), {{0, 1.0}});
  for (int v = 0; v < int(s.position.size()); ++v) s.wedges.push_back({v, 0});
  s.attributes.resize(Eigen::Index(s.wedges.size()), 0);
  return s;
}

void add_triangle(Surface& s, int a, int b, int c) { s.add_face(std::array{a, b, c}); }

void add_quad(Surface& s, int a, int b, int c, int d) {
  add_triangle(s, a, b, c);
  add_triangle(s, a, c, d);
}

// Points that agree on a fine lattice are one vertex: lets the sides of a box share their edges.
struct Lattice {
  std::vector<Vec3> position;
  std::map<std::array<long long, 3>, int> seen;

  int at(const Vec3& x) {
    const std::array key{std::llround(x.x() * 1e6), std::llround(x.y() * 1e6), std::llround(x.z() * 1e6)};
    const auto [place, fresh] = seen.try_emplace(key, int(position.size()));
    if (fresh) position.push_back(x);
    return place->second;
  }
};

// A box with n[i] quads along axis i.
Surface lattice_box(const Vec3& size, const std::array<int, 3>& n) {
  Lattice lattice;
  std::vector<std::array<int, 4>> quads;
  for (int axis = 0; axis < 3; ++axis) {
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    for (const int side : {-1, 1}) {
      for (int a = 0; a < n[size_t(i)]; ++a) {
        for (int b = 0; b < n[size_t(j)]; ++b) {
          const auto corner = [&](int da, int db) {
            Vec3 x;
            x[axis] = side * size[axis] / 2;
            x[i] = size[i] * (double(a + da) / n[size_t(i)] - 0.5);
            x[j] = size[j] * (double(b + db) / n[size_t(j)] - 0.5);
            return lattice.at(x);
          };
          if (side > 0) {
            quads.push_back({corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)});
          } else {
            quads.push_back({corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)});
          }
        }
      }
    }
  }
  Surface s = bare(std::move(lattice.position));
  for (const auto& [a, b, c, d] : quads) add_quad(s, a, b, c, d);
  return s;
}

// A chain of joints one apart along +y, joint j at height j * spacing.
Skeleton chain_of_joints(int joints, double spacing) {
  Skeleton skeleton;
  for (int j = 0; j < joints; ++j) {
    Node node{.name = "joint" + std::to_string(j), .parent = j - 1};
    if (j > 0) node.rest.translation = Vec3(0, spacing, 0);
    skeleton.nodes.push_back(node);
    Joint joint{.node = j};
    joint.inverse_bind.col(3) = Vec3(0, -spacing * j, 0);
    skeleton.joints.push_back(joint);
  }
  return skeleton;
}

// Linear weights over the two joints nearest in height.
void bind_by_height(Surface& s, int joints, double spacing, double base) {
  for (size_t v = 0; v < s.position.size(); ++v) {
    const double h = std::clamp((s.position[v].y() - base) / spacing - 0.5, 0.0, joints - 1.0);
    const int j = std::min(int(h), joints - 2);
    const double w = h - j;
    s.influences[v].clear();
    if (w < 1) s.influences[v].push_back({j, 1 - w});
    if (w > 0) s.influences[v].push_back({j + 1, w});
  }
}

// Key 0 at rest, key 1 (one second) turned by `angle` about `axis`, for every joint but the root.
Clip turning(const std::string& name, int joints, const Vec3& axis, double angle) {
  Clip clip{.name = name, .channels = {}};
  for (int j = 1; j < joints; ++j) {
    Channel channel{j, Path::Rotation, Interpolation::Linear, {0, 1}, Rows(2, 4)};
    channel.values.row(0) << 0, 0, 0, 1;
    channel.values.row(1) << std::sin(angle / 2) * axis.transpose(), std::cos(angle / 2);
    clip.channels.push_back(channel);
  }
  return clip;
}

}  // namespace

Surface grid_box(const Vec3& size, int n) { return lattice_box(size, {n, n, n}); }

Surface tube(int around, int rings, double length, bool closed) {
  std::vector<Vec3> position;
  for (int r = 0; r <= rings; ++r) {
    for (int a = 0; a < around; ++a) {
      const double angle = 2 * std::numbers::pi * a / around;
      position.emplace_back(std::cos(angle), length * r / rings, std::sin(angle));
    }
  }
  if (closed) {
    position.emplace_back(0, 0, 0);
    position.emplace_back(0, length, 0);
  }
  Surface s = bare(std::move(position));
  const auto at = [&](int r, int a) { return r * around + a % around; };
  for (int r = 0; r < rings; ++r) {
    for (int a = 0; a < around; ++a) add_quad(s, at(r, a), at(r + 1, a), at(r + 1, a + 1), at(r, a + 1));
  }
  for (int a = 0; closed && a < around; ++a) {
    const int bottom = (rings + 1) * around;
    add_triangle(s, bottom, at(0, a), at(0, a + 1));
    add_triangle(s, bottom + 1, at(rings, a + 1), at(rings, a));
  }
  return s;
}

Surface sphere(int level) {
  std::vector<Vec3> position = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::array<int, 3>> faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                           {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int l = 0; l < level; ++l) {
    std::map<std::pair<int, int>, int> middle;
    const auto half = [&](int a, int b) {
      const auto [place, fresh] = middle.try_emplace({std::min(a, b), std::max(a, b)}, int(position.size()));
      if (fresh) position.push_back((position[size_t(a)] + position[size_t(b)]).normalized());
      return place->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const int ab = half(a, b), bc = half(b, c), ca = half(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  Surface s = bare(std::move(position));
  for (const auto& [a, b, c] : faces) add_triangle(s, a, b, c);
  return s;
}

Surface torus(int around, int through) {
  std::vector<Vec3> position;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < through; ++j) {
      const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / through;
      const double r = 2 + std::cos(v) / 2;
      position.emplace_back(r * std::cos(u), std::sin(v) / 2, r * std::sin(u));
    }
  }
  Surface s = bare(std::move(position));
  const auto at = [&](int i, int j) { return (i % around) * through + j % through; };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < through; ++j) add_quad(s, at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
  }
  return s;
}

Surface sheet(int n) {
  Surface s;
  s.layout = {.normal = true, .tangent = true, .uv_sets = 1};
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      s.position.push_back(Vec3(double(i) / n, double(j) / n, 0));
      s.wedges.push_back({int(s.position.size()) - 1, 0});
    }
  }
  s.influences.assign(s.position.size(), {{0, 1.0}});
  s.attributes.resize(Eigen::Index(s.wedges.size()), s.layout.columns());
  for (Eigen::Index w = 0; w < s.attributes.rows(); ++w) {
    const Vec3& x = s.position[size_t(w)];
    s.attributes.row(w) << 0, 0, 1, 1, 0, 0, -1, 0.2 + 0.5 * x.x(), 0.9 - 0.5 * x.y();
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int a = i * (n + 1) + j, b = a + n + 1;
      s.add_face(std::array{a, b, b + 1}), s.add_face(std::array{a, b + 1, a + 1});
    }
  }
  return s;
}

Character bending_tube(int around, int rings, int joints) {
  Character c;
  c.name = "bending_tube";
  c.skeleton = chain_of_joints(joints, 1);
  c.skeleton.nodes.push_back({.name = "body"});
  c.materials = {{.name = "skin"}};
  Surface& s = c.surface;
  s = tube(around, rings, joints, true);
  bind_by_height(s, joints, 1, 0);

  s.layout = {.normal = true, .tangent = false, .uv_sets = 1, .colour_sets = 0};
  c.parts = {{.name = "body", .node = joints, .material = 0, .has = s.layout}};
  const int poles = (rings + 1) * around;
  std::vector<Eigen::RowVectorXd> rows;
  const auto describe = [&](const Vec3& normal, double u, double v) {
    Eigen::RowVectorXd row(5);
    row << normal.transpose(), u, v;
    rows.push_back(row);
  };
  for (int v = 0; v < int(s.position.size()); ++v) {
    const Vec3& x = s.position[size_t(v)];
    if (v < poles) {
      describe(Vec3(x.x(), 0, x.z()), double(v % around) / around, x.y() / joints);
    } else {
      describe(Vec3(0, v == poles ? -1 : 1, 0), 0.5, v == poles ? 0 : 1);
    }
  }
  // The seam: faces of the last column use wedges of their own on the first column's vertices, at u = 1.
  // The rims: the caps use wedges of their own with the caps' normals.
  std::map<std::pair<int, int>, int> extra;
  const auto wedge = [&](int v, int kind, const Vec3& normal, double u) {
    const auto [place, fresh] = extra.try_emplace({v, kind}, int(s.wedges.size()));
    if (fresh) {
      s.wedges.push_back({v, 0});
      describe(normal, u, s.position[size_t(v)].y() / joints);
    }
    return place->second;
  };
  for (int f = 0; f < s.face_count(); ++f) {
    const int begin = s.face_begin[size_t(f)];
    const bool cap = s.corners[size_t(begin)] >= poles;
    bool first = false, last = false;
    for (int i = 0; i < 3; ++i) {
      const int v = s.corners[size_t(begin + i)];
      first |= v < poles && v % around == 0, last |= v < poles && v % around == around - 1;
    }
    for (int i = 0; i < 3; ++i) {
      int& corner = s.corners[size_t(begin + i)];
      const int v = corner;
      if (v >= poles) continue;
      const bool turn = first && last && v % around == 0;
      const double u = turn ? 1 : double(v % around) / around;
      const Vec3& x = s.position[size_t(v)];
      if (cap) {
        corner = wedge(v, turn ? 3 : 2, Vec3(0, v < around ? -1 : 1, 0), u);
      } else if (turn) {
        corner = wedge(v, 1, Vec3(x.x(), 0, x.z()), u);
      }
    }
  }
  s.attributes.resize(Eigen::Index(rows.size()), 5);
  for (size_t i = 0; i < rows.size(); ++i) s.attributes.row(Eigen::Index(i)) = rows[i];

  const double degree = std::numbers::pi / 180;
  c.clips = {turning("bend", joints, Vec3(0, 0, 1), 40 * degree),
             turning("twist", joints, Vec3(0, 1, 0), 30 * degree)};
  return c;
}

Character part_of(Character whole, const std::function<bool(const Vec3& middle)>& inside) {
  Surface& s = whole.surface;
  Surface part = s;
  part.corners.clear(), part.face_begin = {0};
  for (int f = 0; f < s.face_count(); ++f) {
    Vec3 middle = Vec3::Zero();
    for (const int w : s.face(f)) middle += s.position[size_t(s.wedges[size_t(w)].vertex)];
    if (inside(middle / double(s.face(f).size()))) part.add_face(s.face(f));
  }
  s = std::move(part);
  return whole;
}

Character square_column(int n, int rings) {
  Character c;
  c.name = "square_column";
  c.skeleton = chain_of_joints(5, 1.6);
  c.skeleton.nodes.push_back({.name = "column"});
  c.skeleton.nodes.back().rest.translation = Vec3::Zero();
  c.surface = lattice_box(Vec3(1, 8, 1), {n, rings, n});
  for (Vec3& x : c.surface.position) x.y() += 4;
  bind_by_height(c.surface, 5, 1.6, 0);
  c.parts = {{.name = "column", .node = 5, .material = -1, .has = {}}};
  const double degree = std::numbers::pi / 180;
  c.clips = {turning("bend", 5, Vec3(0, 0, 1), 35 * degree), turning("twist", 5, Vec3(0, 1, 0), 40 * degree)};
  return c;
}

PoseSet few_poses(const Character& c) {
  return choose_poses(
      c, {.from_clips = 3, .range_of_motion = 1, .unseen_clip_frames = 3, .unseen_range_of_motion = 1});
}

bool same(const Surface& a, const Surface& b) {
  return a.position == b.position && a.influences == b.influences && a.attributes == b.attributes &&
         a.corners == b.corners;
}

}  // namespace skinlod
