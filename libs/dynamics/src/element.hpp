// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "block_pattern.hpp"
#include "crease/base/types.hpp"
#include "crease/dynamics/assemble.hpp"
#include "crease/dynamics/inertia.hpp"
#include "element_kernels.hpp"

namespace crease {

/// Signed material area [m^2].
inline double material_area(const std::array<Vec2, 3>& X) {
  const Vec2 b = X[1] - X[0], c = X[2] - X[0];
  return 0.5 * (b.x() * c.y() - b.y() * c.x());
}

/// What the world velocities w_i = xdot_i - F Xdot_i of the material at its corners say about one triangle.
struct TriangleMotion {
  std::array<Vec3, 3> p;      ///< nodal momentum rho A/12 (w_i + sum w) = integral of rho alpha_i v [kg m/s]
  double kinetic_energy = 0;  ///< rho A/24 (sum |w_i|^2 + |sum w|^2) [J]
};

inline TriangleMotion triangle_motion(const std::array<Vec3, 3>& w, double mass) {
  const Vec3 sum = w[0] + w[1] + w[2];
  TriangleMotion motion;
  for (int i = 0; i < 3; ++i) motion.p[i] = mass / 12 * (w[i] + sum);
  motion.kinetic_energy =
      mass / 24 * (w[0].squaredNorm() + w[1].squaredNorm() + w[2].squaredNorm() + sum.squaredNorm());
  return motion;
}

Moduli moduli_of(const Material& material);
/// 3 s B, see BendingElement [J].
double scaled(double bending);
FaceConstants face_constants(const Material& material, const Vec3& gravity, double stiffness_scale);

/// Writes what the kernels want to know of an element into its lane.
void read_face(const Cloth& cloth, int face, FaceBatch& batch, int lane);
void read_hinge(const Mesh& mesh, const Hinge& hinge, HingeBatch& batch, int lane);

/// What a face carries: all but the bending energy.
Energies energies_of(const FaceBatch& batch, int lane);

/// Throws std::invalid_argument if this processor does not run them.
const ElementKernels& find_element_kernels(ElementKernelSet set);

}  // namespace crease
