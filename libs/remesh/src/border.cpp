// SPDX-License-Identifier: MIT
#include "border.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace crease {

Border::Border(const Mesh& mesh) {
  for (int h = 0; h < 3 * mesh.face_slots(); ++h) {
    if (!mesh.face_live(Mesh::face_of(h)) || !mesh.is_border(h)) continue;
    segments_.push_back({mesh.X[mesh.from(h)], mesh.X[mesh.to(h)]});
    if (mesh.is_material_corner(mesh.from(h))) corners_.push_back(mesh.X[mesh.from(h)]);
  }
}

double Border::distance_along(const Vec2& P, const Vec2& direction, double cosine) const {
  double nearest2 = std::numeric_limits<double>::infinity();
  for (const Segment& s : segments_) {
    const Vec2 e = s.b - s.a;
    const double t = std::clamp(e.dot(P - s.a) / e.squaredNorm(), 0.0, 1.0);
    const double distance2 = (s.a + t * e - P).squaredNorm();
    if (distance2 < nearest2 && std::abs(e.dot(direction)) >= cosine * e.norm()) nearest2 = distance2;
  }
  return std::sqrt(nearest2);
}

double Border::corner_distance(const Vec2& P) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec2& corner : corners_) nearest = std::min(nearest, (corner - P).norm());
  return nearest;
}

}  // namespace crease
