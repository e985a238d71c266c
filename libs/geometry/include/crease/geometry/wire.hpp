// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "crease/base/types.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// Whether the feature is a wire's segment or joint: it has no normals of its own.
/// @pre the feature exists
bool is_on_wire(const FeatureId& feature, const ObstacleShape& shape);

/// Direction in which a wire pushes the EOL vertex that rides on it: away from the wire, unit, orthogonal to `tangent`
/// (unit, or zero at a joint). On flat cloth its normal, turned by FeatureId::side; the more it folds, the more the
/// bisector of the fold, outwards, which stays known where the two sides hang back to back and their normals cancel.
/// Zero where it is not known: side 0, or no faces.
Vec3 wire_normal(const Cloth& cloth, int vertex, const Vec3& tangent);

/// Direction in which an edge or corner between faces pushes the EOL vertex that rides on it: the normal of the cloth
/// there, turned to the outside, on a fold its bisector; or the nearest to it in the cone of `normals`. Unit.
/// @param tangent  of the edge, unit; zero at a corner
/// @pre normals not empty
Vec3 support_normal(const Cloth& cloth, int vertex, const Vec3& tangent, std::span<const Vec3> normals);

/// Gives EOL vertices on wires whose side is not known, because a link or a split of their chain made them, that of
/// their neighbours on the chain; with none, the side on which they are.
void spread_wire_sides(Cloth& cloth, std::span<const PosedObstacle> obstacles);

}  // namespace crease
