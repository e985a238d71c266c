// SPDX-License-Identifier: MIT
#pragma once

#include "element_math.hpp"

namespace crease {

/// So many elements go through the kernels at once, one a lane.
constexpr int batch_lanes = 8;
using Lanes = double[batch_lanes];

struct FaceConstants {
  Moduli moduli;
  double density;          ///< [kg/m^2]
  double stiffness_scale;  ///< h^2 + h damping [s^2]
  double gravity[3];       ///< [m/s^2]
};

/// Faces, a number of each in every lane. Given their corners in order, of the material (X, V) and of the world (x, v):
struct alignas(64) FaceBatch {
  Lanes X[3][2], V[3][2], x[3][3], v[3][3];
  Lanes double_area;  ///< twice that of the material [m^2]
  // What the kernel makes of it:
  Lanes mass;                              ///< rho A [kg]
  Lanes F[2][3];                           ///< its columns
  Lanes membrane, kinetic, gravitational;  ///< energies [J]
  Lanes momentum[3], angular_momentum[3];  ///< [kg m/s], [kg m^2/s]
  Lanes impulse[3][3];                     ///< nodal momentum rho A/12 (w_i + sum w), w_i = xdot_i - F Xdot_i
  Lanes force[3][3];                       ///< of membrane and weight on each corner [N]
  Lanes H[6][9];  ///< M + stiffness_scale K, blocks (0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2) column by column
};

/// The same of hinges, corners in the order of BendingElement.
struct alignas(64) HingeBatch {
  Lanes X[4][2], x[4][3];
  Lanes energy;       ///< [J]
  Lanes force[4][3];  ///< [N]
  Lanes weight[10];   ///< of the unit blocks of stiffness_scale K: (0, 0), (0, 1), (1, 1), (0, 2), .. (3, 3)
};

/// The elements' inner loops, one set for each kind of processor. They are compiled with that processor's instructions
/// and must not be called on another. All give the same bytes.
struct ElementKernels {
  void (*faces)(const FaceConstants& constants, FaceBatch& batch);
  /// @param scaled_bending  3 s B, see BendingElement [J]
  void (*hinges)(double scaled_bending, double stiffness_scale, HingeBatch& batch);
};

const ElementKernels& generic_element_kernels();
#if defined(__x86_64__)
const ElementKernels& avx2_element_kernels();
const ElementKernels& avx512_element_kernels();
#endif

}  // namespace crease
