// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "crease/geometry/cloth.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// Pose at `time` with the constant twist that carries it to its pose at `time + h`.
Pose mean_motion(const Obstacle& obstacle, double time, double h);

/// After the positions were advanced to `time`, looks at every EOL vertex:
///  - closed on all normals of its feature's cone: put back onto the feature (round-off only);
///  - some normals open, others closed, by less than `threshold`: the fold has moved a hair along the surface that
///  still
///    lies on the obstacle; the vertex is seated again at the feature, sliding along that surface in material and
///    world;
///  - open on all normals, or by more, or past the end of the edge: it has separated and becomes Lagrangian.
/// @return the number released
int track_features(Cloth& cloth, std::span<const Obstacle> obstacles, double time, double threshold);

}  // namespace crease
