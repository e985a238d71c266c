// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>

#include "crease/base/types.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// A point counts as lying on a rim (an edge or corner of the surface) nearer than this [m]: round-off of coordinates
/// of a metre, far below any contact threshold. There the direction from the rim to the point means nothing any more.
constexpr double rim_tolerance = 1e-9;

/// The point of an obstacle's surface that is nearest to some point.
struct SurfacePoint {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< unit, outward; on a rim the mean of the rim's normals
  double distance = 0;         ///< negative inside [m]
  int n_rim = 0;               ///< 0, or the number of faces that meet in the rim the point lies on
  std::array<Vec3, 3> rim_normals;
};

/// Nothing if the obstacle has no surface. World coordinates.
std::optional<SurfacePoint> nearest_on_surface(const PosedObstacle& obstacle, const Vec3& p);

}  // namespace crease
