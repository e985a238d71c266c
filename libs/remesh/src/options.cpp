// SPDX-License-Identifier: MIT
#include "options.hpp"

#include <cmath>

#include "crease/base/require.hpp"

namespace crease {

void require_valid(const AdaptOptions& options) {
  const auto [shortest, longest] = options.size;
  require(std::isfinite(shortest) && shortest > 0,
          "adapt: expected size[0] > 0 (the shortest edge, in metres), got " + std::to_string(shortest));
  require(std::isfinite(longest) && longest >= shortest,
          "adapt: expected size[1] >= size[0] (the longest edge, in metres), got " + std::to_string(longest));
  require(options.angle > 0, "adapt: expected angle > 0 rad, got " + std::to_string(options.angle));
  require(options.velocity > 0, "adapt: expected velocity > 0 m/s, got " + std::to_string(options.velocity));
  require(options.compression > 0, "adapt: expected compression > 0 m, got " + std::to_string(options.compression));
  require(options.aspect > 0 && options.aspect <= 1,
          "adapt: expected aspect in (0, 1], got " + std::to_string(options.aspect));
  require(options.threshold > 0, "adapt: expected threshold > 0 m, got " + std::to_string(options.threshold));
}

void require_valid(const ConformOptions& options) {
  require(std::isfinite(options.snap) && options.snap > 0,
          "conform: expected snap > 0 m, got " + std::to_string(options.snap));
  require(std::isfinite(options.merge) && options.merge > 0,
          "conform: expected merge > 0 m, got " + std::to_string(options.merge));
  require(std::isfinite(options.look_ahead) && options.look_ahead >= 0,
          "conform: expected look_ahead >= 0 s, got " + std::to_string(options.look_ahead));
  require(std::isfinite(options.clearance) && options.clearance >= 0,
          "conform: expected clearance >= 0 m, got " + std::to_string(options.clearance));
  require(options.border_angle_deg >= 0 && options.border_angle_deg < 90,
          "conform: expected border_angle_deg in [0, 90), got " + std::to_string(options.border_angle_deg));
}

const char* to_string(RefusalReason reason) {
  switch (reason) {
    case RefusalReason::BudgetSpent:
      return "budget spent";
    case RefusalReason::WouldInvert:
      return "would invert a triangle";
    case RefusalReason::TooThin:
      return "triangle too thin";
    case RefusalReason::NotConnected:
      return "chain not connected";
    case RefusalReason::NearBorder:
      return "too near to the border";
    case RefusalReason::AtCorner:
      return "at a corner of the cloth";
    case RefusalReason::Separating:
      return "moving away from the feature";
    case RefusalReason::WouldLoseChain:
      return "would lose the chain";
    case RefusalReason::NotManifold:
      return "would not be a manifold";
    case RefusalReason::Pinned:
      return "pinned";
    case RefusalReason::WouldMoveSurface:
      return "would move the surface";
    case RefusalReason::NearObstacle:
      return "would move the surface near an obstacle";
    case RefusalReason::OnSeam:
      return "on a seam";
  }
  return "unknown";
}

}  // namespace crease
