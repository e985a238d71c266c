// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "crease/base/types.hpp"
#include "crease/dynamics/assemble.hpp"
#include "crease/dynamics/inertia.hpp"

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

/// One face, read out of a cloth.
struct FaceState {
  std::array<int, 3> vertex;
  TriangleState state;
  bool eol = false;  ///< has an Eulerian corner; only then F is not zero
  Mat32 F = Mat32::Zero();
  double mass = 0;  ///< rho A [kg]
  TriangleMotion motion;
};

FaceState read_face(const Cloth& cloth, int face, double density);

/// What a face carries: all but the bending energy.
Energies energies_of(const FaceState& face, const Vec3& gravity, double membrane);

}  // namespace crease
