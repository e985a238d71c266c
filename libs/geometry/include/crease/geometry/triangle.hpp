// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "crease/base/types.hpp"
#include "crease/geometry/mesh.hpp"

namespace crease {

/// Twice the signed area of abc, positive if counter-clockwise. The sign is exact for finite coordinates (a rounded
/// determinant is accepted only when its error bound allows it, else the sum is redone without rounding), so two
/// callers never disagree about which side of a line a point is on.                                  [SHEWCHUK97]
double orient2d(const Vec2& a, const Vec2& b, const Vec2& c);

/// Deformation gradient F = Dx DX^-1 of a triangle, 3x2.                                     [WEIDNER18, Eq. 3]
/// @pre positive material area
Mat32 deformation_gradient(const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x);
Mat32 deformation_gradient(const Mesh& mesh, int face);

/// Gradients g_i = grad_X alpha_i of the three barycentric coordinates, one a row (3x2) [1/m]; F = sum_i x_i g_i^T.
Mat32 barycentric_gradients(const std::array<Vec2, 3>& X);

/// Barycentric coordinates of the material point P, Eq. A.3.
Vec3 barycentric(const std::array<Vec2, 3>& X, const Vec2& P);

/// Area-weighted mean of F over the faces at vertex v: the one mean that conserves linear momentum when an Eulerian
/// vertex becomes Lagrangian (angle or plain means lose 6e-3..8e-3 of it).
Mat32 vertex_deformation_gradient(const Mesh& mesh, int v);

std::array<Vec2, 3> material_corners(const Mesh& mesh, int face);
std::array<Vec3, 3> world_corners(const Mesh& mesh, int face);

/// Unit world normal of a face (right-hand rule of its corner order); zero vector if the face is degenerate in world.
Vec3 face_normal(const Mesh& mesh, int face);

/// Smallest altitude of a material triangle [m] and smallest angle [rad].
double smallest_altitude(const std::array<Vec2, 3>& X);
double smallest_angle(const std::array<Vec2, 3>& X);

}  // namespace crease
