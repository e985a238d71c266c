// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "crease/base/types.hpp"

namespace crease {

/// Closest points of two segments a0-a1 and b0-b1.
struct SegmentPair {
  double s, t;      ///< parameters in [0, 1] on a and on b
  double distance;  ///< >= 0 [m]
  bool parallel;    ///< directions within 1e-9 rad (then s, t are one valid choice of many)
};
SegmentPair closest_segments(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1);

/// Barycentric coordinates of the point of triangle abc that is closest to p.
Vec3 closest_on_triangle(const Vec3& p, const std::array<Vec3, 3>& triangle);

}  // namespace crease
