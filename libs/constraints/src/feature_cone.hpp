// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// What a sharp feature allows a vertex on it, in world coordinates.
///
/// `normals` bound the velocity from below, one inequality each; `holds` fix it. A box edge has two normals, a box
/// corner three, a nail one normal and two holds across it, a wire two holds across it and three at a joint: see
/// lie_on(). All turn with the obstacle, so a multiplier keeps its meaning from step to step; none is taken from the
/// cloth, whose orientation is arbitrary.
struct FeatureCone {
  Vec3 point = Vec3::Zero();       ///< on the feature; every normal and hold is orthogonal to the feature there [m]
  std::vector<Vec3> normals = {};  ///< outward unit normals of the obstacle's faces
  std::vector<Vec3> holds = {};    ///< unit, orthogonal to each other
  Vec3 tangent = Vec3::Zero();     ///< of a wire; else zero
};

/// Throws std::invalid_argument unless `feature` names an edge or a corner of one of the obstacles.
FeatureCone feature_cone(const FeatureId& feature, std::span<const PosedObstacle> obstacles);

/// Makes a wire's or joint's hold one-sided for cloth that lies on it towards `normal`: an inequality along it, holds
/// across it alone. A wire can push but not pull.  @pre no normals; `normal` unit, orthogonal to the tangent
void lie_on(FeatureCone& cone, const Vec3& normal);

}  // namespace crease
