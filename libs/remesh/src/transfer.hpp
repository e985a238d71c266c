// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "crease/geometry/cloth.hpp"

namespace crease {

/// World velocity of the material at the corners of one face: xdot - F Xdot with the face's own F (paper Eq. 2).
std::array<Vec3, 3> corner_velocities(const Cloth& cloth, int face);

/// World velocity of the material at from + t (to - from) of an edge: area-weighted mean over the edge's faces, the one
/// that keeps the momentum when a Lagrangian vertex is put there.
Vec3 edge_velocity(const Cloth& cloth, int h, double t);

}  // namespace crease
