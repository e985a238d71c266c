// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>

#include "crease/geometry/cloth.hpp"

// Momentum here is per unit density: the integral of the world velocity over the material [m^3/s]. With linear elements
// a face carries area/3 times the sum of its corners' velocities, whether the mass is lumped or consistent.
namespace crease {

/// World velocity of the material at the corners of one face: xdot - F Xdot with the face's own F (paper Eq. 2).
std::array<Vec3, 3> corner_velocities(const Cloth& cloth, int face);

Vec3 face_momentum(const Cloth& cloth, int face);
Vec3 momentum(const Cloth& cloth, std::span<const int> faces);
Vec3 total_momentum(const Cloth& cloth);

/// World velocity of the material at from + t (to - from) of an edge: area-weighted mean over the edge's faces, the one
/// that keeps the momentum when a Lagrangian vertex is put there.
Vec3 edge_velocity(const Cloth& cloth, int h, double t);

/// Material area that a vertex carries with lumped mass: a third of its faces [m^2].
double lumped_area(const Mesh& mesh, int vertex);

}  // namespace crease
