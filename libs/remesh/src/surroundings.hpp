// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "crease/geometry/obstacle.hpp"

namespace crease {

/// The obstacles that a flip or a collapse must not touch. Asked only about operations that are otherwise due, so it
/// keeps nothing but where the sharp features are.
class Surroundings {
 public:
  Surroundings(std::span<const PosedObstacle> obstacles, double threshold);

  /// Whether the surface may leave one side of these tetrahedra, which an operation sweeps, for the other: no sharp
  /// feature is inside, and where an obstacle is nearer than the threshold, they are no thicker than half of it.
  bool allow(std::span<const std::array<Vec3, 4>> swept) const;

 private:
  struct Segment {
    Vec3 a, b;  // equal for a corner
  };
  bool any_near(std::span<const std::array<Vec3, 4>> swept) const;

  std::span<const PosedObstacle> obstacles_;
  std::vector<Segment> features_;
  double threshold_;
};

}  // namespace crease
