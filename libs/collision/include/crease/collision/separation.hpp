// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>

#include "crease/base/types.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// Distance between a whole triangle and an obstacle's solid by GJK (FCL and libccd) [m]; 0 if they intersect. A second
/// opinion that knows nothing of features: slower than the detector, exact to round-off.
/// std::nullopt if the obstacle has no solid, or if the iteration fails on a degenerate configuration.
std::optional<double> triangle_distance(const std::array<Vec3, 3>& triangle, const PosedObstacle& obstacle);

}  // namespace crease
