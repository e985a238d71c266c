// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "crease/base/types.hpp"
#include "crease/dynamics/material.hpp"

namespace crease {

using Vec9 = Eigen::Matrix<double, 9, 1>;
using Mat9 = Eigen::Matrix<double, 9, 9>;

/// Corotated linear membrane, plane stress, of one triangle in world unknowns (x_a, x_b, x_c).
///
/// psi(F) = mu |S - I|^2 + lambda/2 tr(S - I)^2, F = R S (3x2 polar), mu = E/(2(1+nu)), lambda = E nu/(1-nu^2).
/// `stiffness` is -d force/d x with the negative eigenvalues of d^2 psi/dF^2 (closed form: stretch, twist, flip and the
/// two out-of-plane modes) set to zero, so it is symmetric positive semidefinite yet keeps the geometric stiffness of
/// tension.                                                                              [ETZMUSS03; SMITH19]
struct MembraneElement {
  double energy = 0;   ///< A psi [J]
  double density = 0;  ///< psi [J/m^2]; the exact Eulerian force needs it: -psi A g_i
  Vec9 force;          ///< -d energy/d x [N]
  Mat9 stiffness;      ///< K_m, PSD [N/m]
};
/// @pre positive material area; world triangle may be anything, also degenerate (result stays finite)
MembraneElement membrane_element(const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x, const Material& material);

}  // namespace crease
