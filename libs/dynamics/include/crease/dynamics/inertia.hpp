// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "crease/base/types.hpp"

namespace crease {

using Vec15 = Eigen::Matrix<double, 15, 1>;
using Mat15 = Eigen::Matrix<double, 15, 15>;

/// State of one triangle. Order of all 15-vectors: (x_a, x_b, x_c, X_a, X_b, X_c), as in Eq. 4.
struct TriangleState {
  std::array<Vec2, 3> X;
  std::array<Vec3, 3> x;
  std::array<Vec2, 3> V;  ///< Xdot
  std::array<Vec3, 3> v;  ///< xdot
};

/// Generalised inertia, block ij = rho A/12 (1 + delta_ij) B^T B, B = (I, -F): symmetric, rank 9. [WEIDNER18, Eq. 8]
Mat15 eol_inertia(const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x, double density);

/// C = Mdot qdot - 1/2 d(qdot^T M qdot)/dq of one triangle, the velocity-dependent part of Lagrange's equations that
/// the paper leaves out: the momentum that material carries across the moving fold.
///   w_i = xdot_i - F Xdot_i, S = sum w, p_i = rho A/12 (w_i + S), T = rho A/24 (sum |w_i|^2 + |S|^2),
///   div = sum_j g_j . Xdot_j, Fdot = (Dxdot - F DXdot) DX^-1
///   C_i^L = div p_i - rho A/12 Fdot (Xdot_i + sum_j Xdot_j) + sum_j (g_i . Xdot_j) p_j
///   C_i^E = -F^T C_i^L - Fdot^T p_i - T g_i
/// When all Xdot are zero, C^L is zero on each triangle and C^E in the sum over the triangles at an interior vertex.
/// Power identity: qdot . C = 1/2 qdot^T Mdot qdot.
Vec15 eol_velocity_terms(const TriangleState& state, double density);

/// J (3x15) at barycentric coordinates alpha, Eq. 4.
Eigen::Matrix<double, 3, 15> eol_jacobian(const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x,
                                          const Vec3& alpha);

}  // namespace crease
