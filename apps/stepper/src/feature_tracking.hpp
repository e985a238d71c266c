// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "crease/dynamics/material.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// Pose at `time` with the mean motion of its points until `time + h`: straight, to where they are then.
Pose mean_motion(const Obstacle& obstacle, double time, double h);

struct Tracking {
  double time, h;    ///< end of the step, and its length [s]
  double threshold;  ///< of contacts [m]
  double linger;     ///< see SheetSettings [s]
  const Material& material;
};

/// After the positions were advanced, looks at every EOL vertex: one that stands on its feature is freed of round-off,
/// one that hovers by less than half of the threshold is left as it is, one that has opened further along any normal of
/// the cone, or ran past the end of its edge, has left. But a fold that lifts off an edge of a solid under tension
/// stays one (FeatureId::lifted) until it is flat or slack, or stands on the edge again. What has left lingers
/// (FeatureId::away): back at its feature within `linger`, it rides on; else it becomes Lagrangian, and for `linger` no
/// chain begins where it was (Cloth::left). So as far as tracking goes a chain lives for `linger` at least, and
/// so does a gap in it; what conform() releases may live shorter.
/// @return the number that became Lagrangian
int track_features(Cloth& cloth, std::span<const Obstacle> obstacles, const Tracking& tracking);

}  // namespace crease
