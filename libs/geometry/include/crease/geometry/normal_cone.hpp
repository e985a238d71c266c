// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "crease/base/types.hpp"

namespace crease {

/// A common normal may leave a feature's normal cone by this much [rad] (2 degrees). It lets a flat cloth on the rim of
/// the cone (normal = a face's own normal, up to round-off and a slight curvature) count as lying on the feature.
constexpr double cone_tolerance = 0.0349;

/// Unit mean of the normals of a feature: strictly inside its cone. Zero if they cancel.
Vec3 mean_normal(std::span<const Vec3> normals);

/// Unit vector of the convex cone spanned by unit `normals` that is nearest to the unit vector `direction`.
/// Outside the half space of all of them, the normal nearest to it.
Vec3 nearest_in_cone(std::span<const Vec3> normals, const Vec3& direction);

/// Whether a unit direction lies in the cone, up to `tolerance` [rad]. A single normal is the axis of a tip, which
/// supports every plane that leaves the axis on its outer side: its cone is the half space.
bool in_cone(std::span<const Vec3> normals, const Vec3& direction, double tolerance = cone_tolerance);

}  // namespace crease
