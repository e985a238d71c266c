// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "crease/geometry/cloth.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// Pose at `time` with the constant twist that carries it to its pose at `time + h`.
Pose mean_motion(const Obstacle& obstacle, double time, double h);

/// After the positions were advanced to `time`: an EOL vertex that has moved off its feature (any of the cone's normals
/// opened by more than a small share of `threshold`, or it ran past the end of the edge) becomes Lagrangian; every
/// other one is put back onto its feature.
/// @return the number released
int track_features(Cloth& cloth, std::span<const Obstacle> obstacles, double time, double threshold);

}  // namespace crease
