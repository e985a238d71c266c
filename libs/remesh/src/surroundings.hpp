// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "crease/geometry/obstacle.hpp"

namespace crease {

/// A piece of what the surface sweeps when an operation moves it: a tetrahedron whose face opposite to corner k is of
/// the new surface if `made[k]`, else of the old one or between two pieces.
struct Swept {
  std::array<Vec3, 4> corners;
  std::array<bool, 4> made;
};

/// The obstacles' sharp features, which a flip or a collapse must not cut. Asked only about operations that are
/// otherwise due.
class Surroundings {
 public:
  Surroundings(std::span<const PosedObstacle> obstacles, double threshold);

  /// Whether the surface may go from one side of these tetrahedra to the other: no feature changes sides. What is as
  /// far from the surface as `touch` is on it, and on neither side.
  /// @param shift  by how much the surface moves at most [m]; up to `touch` it may
  /// @param held   features that the cloth has vertices on, there: these hold the surface to them
  bool allow(std::span<const Swept> swept, double shift, std::span<const FeatureId> held) const;
  bool empty() const { return features_.empty(); }

 private:
  struct Segment {
    FeatureId id;
    Vec3 a, b;  // equal for a corner
  };

  std::vector<Segment> features_;
  double touch_;
};

}  // namespace crease
