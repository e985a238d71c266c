// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "crease/geometry/cloth.hpp"
#include "crease/geometry/feature_place.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

using Obstacles = std::span<const PosedObstacle>;

/// How far x stands off the feature: the largest of its signed distances from the planes that meet there, as the solver
/// sees them; the distance from a wire; that from a point, negative behind it [m].
double stand_off(const FeatureId& feature, Obstacles obstacles, const Vec3& x);

/// Velocity of the feature's obstacle at x.
Vec3 velocity_at(const FeatureId& feature, Obstacles obstacles, const Vec3& x);

/// Whether an edge's chain makes way where it crosses the other's: the later one does, unless they meet in a corner.
bool gives_way(const FeatureId& edge, const FeatureId& other, Obstacles obstacles);

/// Whether at x, on the feature, an earlier obstacle has one in the same place, within `reach`: an edge along an edge,
/// an edge or a corner at a corner. A vertex can ride on one of them only, and two chains in one line would have no
/// room between them: the later obstacle's feature stands back, and its contacts with the faces and edges there keep
/// the cloth out of it.
bool stands_back(const FeatureId& feature, Obstacles obstacles, const Vec3& x, double reach);

/// Unit material direction whose image under F is nearest to the world direction d.
Vec2 pull_back(const Mat32& F, const Vec3& d);

}  // namespace crease
