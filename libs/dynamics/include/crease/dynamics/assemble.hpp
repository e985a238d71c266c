// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/dynamics/material.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/dof_map.hpp"

namespace crease {

struct DynamicsOptions {
  Vec3 gravity{0, 0, -9.81};
  bool velocity_terms = true;  ///< false: the paper's equations, without C
};

/// Energies of a sheet, each a sum over its triangles or hinges, and the momenta of its material.
struct Energies {
  double kinetic = 0, membrane = 0, bending = 0, gravitational = 0;  ///< [J]
  Vec3 momentum = Vec3::Zero();                                      ///< linear, of the world velocity field [kg m/s]
  Vec3 angular_momentum = Vec3::Zero();                              ///< about the origin [kg m^2/s]

  double total() const { return kinetic + membrane + bending + gravitational; }
  Energies& operator+=(const Energies& part);
};

/// The linearly implicit step of one sheet, in the unknowns of `dofs`:  H qdot_{k+1} = rhs (+ constraint impulses).
///   H   = M + (h^2 + h damping) K,   K = -df/dq mapped by J^T (.) J with each element's own F (Eq. 10), PSD
///   rhs = M qdot_k + h (f - C),      f = (f, -F^T f) (Eq. 9) + the exact membrane term -psi A g_i on X
struct AssembledSystem {
  SparseMatrix H;  ///< both triangles stored; pattern fixed while the topology and the EOL set stay
  VecX rhs;
  VecX force;         ///< f - C, generalised [N]
  Energies energies;  ///< at q_k
};

/// The elements' inner loops for one kind of processor. All give the same bytes.
enum class ElementKernelSet { Best, Generic, Avx2, Avx512 };

/// Those that this processor runs, Best apart; the fastest last.
std::vector<ElementKernelSet> available_element_kernels();

/// Keeps the sparsity pattern and every element's place in it; rebuilds them only when told that the mesh or the EOL
/// set changed.
class Assembler {
 public:
  Assembler() : Assembler(1) {}
  /// @param threads  >= 1; any number gives the same bytes
  /// @param kernels  have to be available
  explicit Assembler(int threads, ElementKernelSet kernels = ElementKernelSet::Best);
  ~Assembler();
  Assembler(Assembler&&) noexcept;
  Assembler& operator=(Assembler&&) noexcept;

  /// @param same_topology  true promises that faces and EOL set are those of the last call
  /// @pre cloth.mesh.is_compact(), h > 0, valid material. Result is finite if the state is.
  const AssembledSystem& assemble(const Cloth& cloth, const DofMap& dofs, const Material& material,
                                  const DynamicsOptions& options, double h, bool same_topology);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Energies and momenta of a state alone (no system).
Energies measure_energies(const Cloth& cloth, const Material& material, const Vec3& gravity);

}  // namespace crease
