// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "crease/base/types.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// A point counts as lying on a rim (an edge or corner of the surface) nearer than this [m]: round-off of coordinates
/// of a metre, far below any contact threshold. There the direction from the rim to the point means nothing any more.
constexpr double rim_tolerance = 1e-9;

/// A point of an obstacle's surface where the distance to some point has a minimum.
struct SurfacePoint {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();          ///< unit, outward; on a rim the mean of the rim's normals
  double distance = 0;                 ///< negative inside [m]
  std::vector<Vec3> rim_normals = {};  ///< of the faces that meet in the sharp edge or corner it lies on, if it does
};

/// All of them within `reach`, on a convex solid one at most, nothing if the obstacle has no surface. World
/// coordinates. A point that rides on the feature `own` of this obstacle is kept out of the faces around it by that
/// feature's own normals: they are left out, and with them, on a convex solid, everything.
std::vector<SurfacePoint> near_on_surface(const PosedObstacle& obstacle, const Vec3& p, double reach,
                                          const FeatureId& own);

/// The nearest of all.  @pre the obstacle has a surface
SurfacePoint nearest_on_surface(const PosedObstacle& obstacle, const Vec3& p);

}  // namespace crease
