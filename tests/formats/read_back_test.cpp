// SPDX-License-Identifier: MIT
#include "tests/formats/read_back.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>

#include "tests/packed_tube.h"
#include "tests/topology.h"

using namespace skinlod;

namespace {

// What the checks of written levels see in a file, against the level that was written.
struct Seen {
  int cracks, uvs, faces;
  friend bool operator==(const Seen&, const Seen&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Seen& s) {
    return out << s.cracks << " cracks, " << s.uvs << " uvs, " << s.faces << " faces";
  }
};

std::vector<int> points(const ReadBack& back, const Surface& level) {
  std::vector<int> points;
  for (const int w : back.wedge) points.push_back(level.wedges[size_t(w)].vertex);
  return points;
}

Seen seen(const ReadBack& back, const Surface& level) {
  const Pose rest{"bind", Palette(5, identity())};
  return {cracks(back.surface, points(back, level)), turned_uvs(level, back.surface, back.face).turned,
          turned_faces(level, back.surface, {&rest, 1}, back.face).turned};
}

// Moves a wedge that is not the only one at its point to a vertex of its own, and says to which.
size_t part_wedge(Surface& s, const std::vector<int>& points) {
  for (size_t w = points.size() - 1; w > 0; --w) {
    const auto v = size_t(s.wedges[w].vertex);
    const auto others = std::span(points).first(w);
    const bool shared = std::find(others.begin(), others.end(), points[w]) != others.end();
    if (!shared || s.morphs[v].empty() || s.influences[v].size() < 2) continue;
    s.wedges[w].vertex = int(s.position.size());
    s.position.push_back(Vec3(s.position[v])), s.influences.push_back(Influences(s.influences[v]));
    s.morphs.push_back(MorphOffsets(s.morphs[v]));
    return s.position.size() - 1;
  }
  FAIL("no point has two wedges");
  return 0;
}

void check_finds(const ReadBack& back, const Surface& level) {
  CHECK(seen(back, level) == Seen{0, 0, 0});

  const std::vector<int> at = points(back, level);
  const auto with = [&](const auto& change) {
    ReadBack changed = back;
    change(changed.surface);
    return seen(changed, level);
  };
  const auto up = [](double& x) { x = std::nextafter(x, std::numeric_limits<double>::infinity()); };
  CHECK(with([&](Surface& s) { part_wedge(s, at); }) == Seen{0, 0, 0});
  CHECK(with([&](Surface& s) { up(s.position[part_wedge(s, at)].y()); }) == Seen{1, 0, 0});
  CHECK(with([&](Surface& s) { up(s.influences[part_wedge(s, at)][1].weight); }) == Seen{1, 0, 0});
  CHECK(with([&](Surface& s) { up(s.morphs[part_wedge(s, at)][0].delta.y()); }) == Seen{1, 0, 0});
  CHECK(with([&](Surface& s) { s.morphs[part_wedge(s, at)].clear(); }) == Seen{1, 0, 0});

  CHECK(with([](Surface& s) { std::swap(s.corners[30], s.corners[31]); }) == Seen{0, 2, 1});
  const Seen far = with([&](Surface& s) {  // a corner of several faces, beyond one of its neighbours
    const int uv = level.layout.uv_at(0), w = s.corners[30];
    const Eigen::RowVectorXd way = s.attributes.row(s.corners[31]) - s.attributes.row(w);
    s.attributes.row(w).segment<2>(uv) += 100 * way.segment<2>(uv);
  });
  CHECK(far.uvs > 0);
  CHECK(far.uvs < 8);
  CHECK(far.faces == 0);
}

}  // namespace

TEST_SUITE("read_back") {
  TEST_CASE("a file has its level whole, and one bit or one face that is not the level's is found") {
    const Character c = decorated_tube(12, 10);
    const std::vector<Level> levels = tube_levels();
    const SlodFile file = read_slod(pack(c, levels), "packed");
    for (size_t l = 0; l + 1 < levels.size(); ++l) {
      CAPTURE(l);
      const Surface& level = levels[l].surface;
      check_finds(as_it_is(level), level);
      check_finds(read_back(level, file.levels[l]), level);
      check_finds(read_back(level, c, nullptr), level);
    }
  }

  TEST_CASE("a face that is turned no farther than its corners are uncertain does not count") {
    Surface s = sheet(1), turned = s;
    const Pose rest{"bind", {identity()}};
    for (Vec3& x : turned.position) x.y() *= -1e-3;
    const auto within = [&](double reach) {
      const auto everywhere = [=](int, const Palette&) { return reach; };
      return turned_faces(s, turned, {&rest, 1}, {}, everywhere).turned;
    };
    CHECK(within(0) == 2);
    CHECK(within(3e-4) == 2);
    CHECK(within(6e-4) == 0);
    turned.attributes.col(s.layout.uv_at(0)) *= -1e-3;
    CHECK(turned_uvs(s, turned).turned == 2);
    CHECK(turned_uvs(s, turned, {}, 1e-4).turned == 2);
    CHECK(turned_uvs(s, turned, {}, 6e-4).turned == 0);
  }
}
