// SPDX-License-Identifier: MIT
#include "pipeline/facets.h"

namespace skinlod {
namespace {

constexpr double kOneDegree = 0.99985;  // its cosine

}  // namespace

Vec3 vector_area(const Surface& surface, int f) {
  const auto face = surface.face(f);
  const auto at = [&](size_t i) -> const Vec3& { return surface.position[surface.wedges[face[i]].vertex]; };
  Vec3 sum = Vec3::Zero();
  for (size_t i = 2; i < face.size(); ++i) sum += (at(i - 1) - at(0)).cross(at(i) - at(0)) / 2;
  return sum;
}

std::vector<char> flat_wedges(const Surface& surface) {
  std::vector<char> flat(surface.wedges.size(), surface.layout.normal);
  for (int f = 0; surface.layout.normal && f < surface.face_count(); ++f) {
    const Vec3 n = vector_area(surface, f).normalized();
    for (const int w : surface.face(f)) {
      const Vec3 given = surface.attributes.row(w).segment<3>(surface.layout.normal_at());
      flat[w] = flat[w] && given.dot(n) > kOneDegree;
    }
  }
  return flat;
}

void shade_flat(Surface& surface, const std::vector<char>& flat) {
  std::vector<Vec3> facet(surface.wedges.size(), Vec3::Zero());
  for (int f = 0; f < surface.face_count(); ++f) {
    for (const int w : surface.face(f)) {
      if (flat[w]) facet[w] += vector_area(surface, f);
    }
  }
  for (size_t w = 0; w < facet.size(); ++w) {
    const double size = facet[w].norm();
    if (size > 0)
      surface.attributes.row(Eigen::Index(w)).segment<3>(surface.layout.normal_at()) =
          facet[w].transpose() / size;
  }
}

}  // namespace skinlod
