// SPDX-License-Identifier: MIT
#include "crease/dynamics/membrane.hpp"

#include "crease/base/require.hpp"
#include "crease/geometry/triangle.hpp"
#include "element.hpp"

namespace crease {

Moduli moduli_of(const Material& material) {
  return {material.youngs / (2 * (1 + material.poisson)),
          material.youngs * material.poisson / (1 - material.poisson * material.poisson)};
}

MembraneElement membrane_element(const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x, const Material& material) {
  const Mat32 F = deformation_gradient(X, x), g = barycentric_gradients(X);
  const double g1[2] = {g(1, 0), g(1, 1)}, g2[2] = {g(2, 0), g(2, 1)};
  const Axes<double> a{{F(0, 0), F(1, 0), F(2, 0)}}, b{{F(0, 1), F(1, 1), F(2, 1)}};
  const double area = 0.5 * orient2d(X[0], X[1], X[2]);
  const auto terms = membrane_terms(moduli_of(material), area, singular_values(a, b), g1, g2);
  MembraneElement element;
  element.density = terms.density;
  element.energy = area * terms.density;
  for (int k = 0; k < 9; ++k) element.force[k] = terms.force[k / 3][k % 3];
  const Mat3 K11 = Eigen::Map<const Mat3>(terms.K11), K12 = Eigen::Map<const Mat3>(terms.K12),
             K22 = Eigen::Map<const Mat3>(terms.K22);
  const Mat3 K21 = K12.transpose(), K01 = -(K11 + K21), K02 = -(K12 + K22);
  element.stiffness << (K11 + K22) + (K12 + K21), K01, K02,  //
      K01.transpose(), K11, K12,                             //
      K02.transpose(), K21, K22;
  return element;
}

}  // namespace crease
