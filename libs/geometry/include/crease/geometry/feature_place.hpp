// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "crease/base/types.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// Whether the feature's obstacle, and on it the feature, is there.
bool exists(const FeatureId& feature, std::span<const PosedObstacle> obstacles);

/// A sharp edge where it is now.
struct WorldEdge {
  Vec3 a, tangent;  ///< starts at a; unit tangent
  double length;
  double parameter(const Vec3& x) const { return (x - a).dot(tangent); }  ///< [m], in [0, length] on the edge
};

/// The edge of that name where it is now.  @pre one of the obstacles has it; kind Edge
WorldEdge world_edge(const FeatureId& edge, std::span<const PosedObstacle> obstacles);

/// The point of the feature that is closest to x [m].  @pre one of the obstacles has it
Vec3 nearest_on(const FeatureId& feature, std::span<const PosedObstacle> obstacles, const Vec3& x);

/// Whether a vertex that rides on `vertex` is on the edge: EOL on it, or at a corner where it ends.  @pre `edge` is of
/// kind Edge
bool lies_on(const FeatureId& vertex, const FeatureId& edge, std::span<const PosedObstacle> obstacles);

}  // namespace crease
