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
/// corner three, a nail one normal and two holds across it, a wire two holds across it and three at a joint. All turn
/// with the obstacle, so a multiplier keeps its meaning from step to step; none is taken from the cloth, whose
/// orientation is arbitrary.
struct FeatureCone {
  Vec3 point = Vec3::Zero();       ///< on the feature; every normal and hold is orthogonal to the feature there [m]
  std::vector<Vec3> normals = {};  ///< outward unit normals of the obstacle's faces
  std::vector<Vec3> holds = {};    ///< unit, orthogonal to each other and to `open`
  Vec3 open = Vec3::Zero();        ///< the direction that the holds leave; zero if there is none
};

/// Throws std::invalid_argument unless `feature` names an edge or a corner of one of the obstacles.
FeatureCone feature_cone(const FeatureId& feature, std::span<const PosedObstacle> obstacles);

}  // namespace crease
