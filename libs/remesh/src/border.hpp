// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "crease/geometry/mesh.hpp"

namespace crease {

/// The cloth's border as a set of points in material space, taken before anything is changed: remeshing moves vertices
/// along it but not the border itself.
class Border {
 public:
  explicit Border(const Mesh& mesh);

  /// Distance from P to the nearest stretch of border that makes an angle below acos(`cosine`) with the unit vector
  /// `direction`; infinity if there is none.
  double distance_along(const Vec2& P, const Vec2& direction, double cosine) const;
  /// Distance from P to the nearest border.
  double distance(const Vec2& P) const { return distance_along(P, Vec2::Zero(), -1); }
  /// Distance from P to the nearest material corner.
  double corner_distance(const Vec2& P) const;

 private:
  struct Segment {
    Vec2 a, b;
  };
  std::vector<Segment> segments_;
  std::vector<Vec2> corners_;
};

}  // namespace crease
