// SPDX-License-Identifier: MIT
#pragma once

namespace crease {

/// Isotropic sheet. Thickness is folded into the constants.
struct Material {
  double density = 0.05;  ///< rho [kg/m^2], > 0
  double youngs = 50;     ///< E [N/m], > 0
  double poisson = 0.3;   ///< nu, in [0, 0.5]
  double bending = 1e-5;  ///< B, plate stiffness as a cantilever shows it [J], >= 0
  double damping = 0;     ///< stiffness-proportional: force = damping * K * v [s], >= 0
};

/// Throws std::invalid_argument naming the first value out of range.
void require_valid(const Material& material);

}  // namespace crease
