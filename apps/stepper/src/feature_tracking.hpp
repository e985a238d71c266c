// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "crease/dynamics/material.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// Pose at `time` with the mean motion of its points until `time + h`: straight, to where they are then.
Pose mean_motion(const Obstacle& obstacle, double time, double h);

/// After the positions were advanced to `time`, looks at every EOL vertex: one that stands on its feature is freed of
/// round-off, one that hovers by less than half of `threshold` is left as it is, one that has opened further along any
/// normal of the cone, or ran past the end of its edge, has separated and becomes Lagrangian. But a fold that lifts off
/// an edge of a solid under tension stays one (FeatureId::lifted) until it is flat or slack, or stands on the edge
/// again.
/// @return the number released
int track_features(Cloth& cloth, std::span<const Obstacle> obstacles, double time, double threshold,
                   const Material& material);

}  // namespace crease
