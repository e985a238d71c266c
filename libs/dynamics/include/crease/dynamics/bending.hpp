// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "crease/base/types.hpp"

namespace crease {

/// Quadratic bending of one interior edge (discrete Willmore energy, constant in x).
///
/// W = 1/2 c |sum_i k_i x_i|^2, vertices ordered (edge from, edge to, opposite of face 0, opposite of face 1),
/// k = cotangent weights on the material triangles, c = 3 s B/(A_0 + A_1).                  [BERGOU06; WARDETZKY07]
/// Differs from the paper: s = 1/3, so that the user's B is the stiffness a cantilever shows on an equilateral mesh;
/// without it the plate is 3 B there. What remains depends on the mesh family (-17 %..+50 %): see the tests.
struct BendingElement {
  Eigen::Vector4d k;  ///< [1/1] scaled cotangents, rows sum to 0
  double c = 0;       ///< [J/m^2]; energy = c/2 |sum k_i x_i|^2, stiffness block ij = c k_i k_j I
};
/// @pre both material triangles have positive area
BendingElement bending_element(const std::array<Vec2, 4>& X, double bending);

}  // namespace crease
