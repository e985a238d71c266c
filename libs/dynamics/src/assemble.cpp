// SPDX-License-Identifier: MIT
#include "crease/dynamics/assemble.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "block_pattern.hpp"
#include "crease/base/require.hpp"
#include "crease/dynamics/bending.hpp"
#include "crease/dynamics/inertia.hpp"
#include "crease/dynamics/membrane.hpp"
#include "crease/geometry/triangle.hpp"
#include "element.hpp"

namespace crease {

namespace {

using Mat5 = Eigen::Matrix<double, 5, 5>;

// B_i^T W B_j with B = (I, -F): a world block in the unknowns (xdot, Xdot) of two vertices.                [Eq. 10]
Mat5 to_eol_block(const Mat3& W, const Mat32& F_i, const Mat32& F_j, bool diagonal) {
  Mat5 block;
  block.topLeftCorner<3, 3>() = W;
  block.topRightCorner<3, 2>() = -W * F_j;
  block.bottomLeftCorner<2, 3>() = -F_i.transpose() * W;
  block.bottomRightCorner<2, 2>() = F_i.transpose() * W * F_j;
  if (diagonal) {  // symmetric up to rounding: make it exact
    for (int row = 1; row < 5; ++row) {
      for (int col = 0; col < row; ++col) block(row, col) = block(col, row);
    }
  }
  return block;
}

// One pass over the elements of a cloth, adding into a system laid out by `pattern`.
struct Pass {
  const Cloth& cloth;
  const DofMap& dofs;
  const Material& material;
  const DynamicsOptions& options;
  const BlockPattern& pattern;
  double stiffness_scale;  // h^2 + h damping [s^2]
  AssembledSystem& system;
  Energies energies = {};

  void add_face(int f);
  void add_hinge(const BlockPattern::HingeBlocks& blocks);

 private:
  void add_face_matrix(const FaceState& face, const Mat9& stiffness, const BlockPattern::FaceBlocks& blocks);
  void add_velocity_terms(const FaceState& face);
  void add_hinge_matrix(const BlockPattern::HingeBlocks& blocks, const BendingElement& element,
                        const std::array<Mat32, 2>* F);
  void add_block(int i, int j, int at_ij, int at_ji, const Mat3& W, const Mat32& F_i, const Mat32& F_j);
  void add_force(int vertex, const Vec3& f, const Mat32& F);
};

// Entry (i, j) of an element whose F is given, and its transpose (j, i); i == j once.
void Pass::add_block(int i, int j, int at_ij, int at_ji, const Mat3& W, const Mat32& F_i, const Mat32& F_j) {
  double* const values = system.H.valuePtr();
  const Mat5 block = to_eol_block(W, F_i, F_j, i == j);
  const int rows = dofs.is_eol(i) ? 5 : 3, cols = dofs.is_eol(j) ? 5 : 3;
  for (int col = 0; col < cols; ++col) {
    for (int row = 0; row < rows; ++row) {
      values[at_ij + col * pattern.stride[j] + row] += block(row, col);
      if (i != j) values[at_ji + row * pattern.stride[i] + col] += block(row, col);
    }
  }
}

void Pass::add_force(int vertex, const Vec3& f, const Mat32& F) {
  system.force.segment<3>(dofs.x(vertex)) += f;
  if (dofs.is_eol(vertex)) system.force.segment<2>(dofs.X(vertex)) -= F.transpose() * f;
}

void Pass::add_face_matrix(const FaceState& face, const Mat9& stiffness, const BlockPattern::FaceBlocks& blocks) {
  double* const values = system.H.valuePtr();
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      Mat3 W = stiffness_scale * stiffness.block<3, 3>(3 * i, 3 * j);
      W.diagonal().array() += face.mass / 12 * (i == j ? 2 : 1);
      const int at_ij = blocks.at[3 * i + j], at_ji = blocks.at[3 * j + i];
      if (face.eol) {
        add_block(face.vertex[i], face.vertex[j], at_ij, at_ji, W, face.F, face.F);
        continue;
      }
      const int stride_i = pattern.stride[face.vertex[i]], stride_j = pattern.stride[face.vertex[j]];
      for (int col = 0; col < 3; ++col) {
        for (int row = 0; row < 3; ++row) {
          values[at_ij + col * stride_j + row] += W(row, col);
          if (i != j) values[at_ji + row * stride_i + col] += W(row, col);
        }
      }
    }
  }
}

// Also where all Xdot are zero: there the terms of the single faces cancel at a vertex only in their sum.
void Pass::add_velocity_terms(const FaceState& face) {
  const Vec15 C = eol_velocity_terms(face.state, material.density);
  for (int i = 0; i < 3; ++i) {
    const int v = face.vertex[i];
    system.force.segment<3>(dofs.x(v)) -= C.segment<3>(3 * i);
    if (dofs.is_eol(v)) system.force.segment<2>(dofs.X(v)) -= C.segment<2>(9 + 2 * i);
  }
}

void Pass::add_face(int f) {
  const FaceState face = read_face(cloth, f, material.density);
  const MembraneElement membrane = membrane_element(face.state.X, face.state.x, material);
  add_face_matrix(face, membrane.stiffness, pattern.faces[f]);
  add_rigid_part(face, options.gravity, energies);
  energies.membrane += membrane.energy;

  for (int i = 0; i < 3; ++i) {
    const int v = face.vertex[i];
    add_force(v, membrane.force.segment<3>(3 * i) + face.mass / 3 * options.gravity, face.F);
    system.rhs.segment<3>(dofs.x(v)) += face.motion.p[i];
    if (dofs.is_eol(v)) system.rhs.segment<2>(dofs.X(v)) -= face.F.transpose() * face.motion.p[i];
  }
  if (!face.eol) return;
  const Mat32 g = barycentric_gradients(face.state.X);
  for (int i = 0; i < 3; ++i) {
    const int v = face.vertex[i];
    if (dofs.is_eol(v)) system.force.segment<2>(dofs.X(v)) -= membrane.energy * g.row(i).transpose();
  }
  if (options.velocity_terms) add_velocity_terms(face);
}

// On a hinge with an Eulerian vertex F is the plain mean of its two faces. At an unstretched fold the bending force is
// along (F_0 - F_1) N and |F_0 N| = |F_1 N|, so this mean, and no other, lets bending push the fold nowhere. Across a
// seam each face has its own material axes, so each side has its own F; on the seam itself no vertex is Eulerian.
void Pass::add_hinge(const BlockPattern::HingeBlocks& blocks) {
  const Mesh& mesh = cloth.mesh;
  const std::array<int, 4>& v = blocks.hinge.vertex;
  const BendingElement element = bending_element(flat_hinge(mesh, blocks.hinge), material.bending);
  Vec3 curvature = Vec3::Zero();
  bool eol = false;
  for (int i = 0; i < 4; ++i) {
    curvature += element.k[i] * mesh.x[v[i]];
    eol = eol || dofs.is_eol(v[i]);
  }
  energies.bending += 0.5 * element.c * curvature.squaredNorm();

  std::array<Mat32, 2> F{Mat32::Zero(), Mat32::Zero()};  // for face 0 and the edge; for the opposite in face 1
  if (eol) {
    for (std::size_t side = 0; side < 2; ++side) F[side] = deformation_gradient(mesh, blocks.hinge.face[side]);
    if (blocks.hinge.sewn_to == Mesh::none) F[0] = F[1] = 0.5 * (F[0] + F[1]);
  }
  for (int i = 0; i < 4; ++i) add_force(v[i], -element.c * element.k[i] * curvature, F[i / 3]);
  add_hinge_matrix(blocks, element, eol ? &F : nullptr);
}

// F = nullptr: all four vertices are Lagrangian.
void Pass::add_hinge_matrix(const BlockPattern::HingeBlocks& blocks, const BendingElement& element,
                            const std::array<Mat32, 2>* F) {
  double* const values = system.H.valuePtr();
  const std::array<int, 4>& v = blocks.hinge.vertex;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const double w = stiffness_scale * element.c * (element.k[i] * element.k[j]);  // same bits for (j, i)
      const int at = blocks.at[4 * i + j];
      if (F == nullptr) {
        for (int axis = 0; axis < 3; ++axis) values[at + axis * (pattern.stride[v[j]] + 1)] += w;
      } else if (i <= j) {
        add_block(v[i], v[j], at, blocks.at[4 * j + i], w * Mat3::Identity(), (*F)[i / 3], (*F)[j / 3]);
      }
    }
  }
}

}  // namespace

struct Assembler::Impl {
  AssembledSystem system;
  BlockPattern pattern;
  bool with_hinges = false;

  void clear(const Mesh& mesh, const DofMap& dofs, bool bends, bool same_topology);
  void finish(const Energies& energies, double h);
};

void Assembler::Impl::clear(const Mesh& mesh, const DofMap& dofs, bool bends, bool same_topology) {
  const bool fits = system.H.rows() == dofs.size() && with_hinges == bends &&
                    pattern.faces.size() == static_cast<std::size_t>(mesh.n_faces());
  if (same_topology && fits) {
    std::fill_n(system.H.valuePtr(), system.H.nonZeros(), 0.0);
  } else {
    pattern = make_block_pattern(mesh, dofs, bends, system.H);
    with_hinges = bends;
  }
  system.rhs.setZero(dofs.size());
  system.force.setZero(dofs.size());
}

void Assembler::Impl::finish(const Energies& energies, double h) {
  system.rhs += h * system.force;
  system.kinetic_energy = energies.kinetic;
  system.membrane_energy = energies.membrane;
  system.bending_energy = energies.bending;
  system.gravitational_energy = energies.gravitational;
  system.momentum = energies.momentum;
  system.angular_momentum = energies.angular_momentum;
}

Assembler::Assembler() : impl_(std::make_unique<Impl>()) {}
Assembler::~Assembler() = default;
Assembler::Assembler(Assembler&&) noexcept = default;
Assembler& Assembler::operator=(Assembler&&) noexcept = default;

const AssembledSystem& Assembler::assemble(const Cloth& cloth, const DofMap& dofs, const Material& material,
                                           const DynamicsOptions& options, double h, bool same_topology) {
  require(cloth.mesh.is_compact(), "Assembler: expected a compact mesh");
  require(dofs.start.size() == static_cast<std::size_t>(cloth.mesh.n_vertices()) + 1,
          "Assembler: expected the DofMap of this cloth");
  require(std::isfinite(h) && h > 0, "Assembler: expected a time step > 0 [s]");
  require_valid(material);

  impl_->clear(cloth.mesh, dofs, material.bending > 0, same_topology);
  Pass pass{.cloth = cloth,
            .dofs = dofs,
            .material = material,
            .options = options,
            .pattern = impl_->pattern,
            .stiffness_scale = h * (h + material.damping),
            .system = impl_->system};
  for (int f = 0; f < cloth.mesh.n_faces(); ++f) pass.add_face(f);
  for (const BlockPattern::HingeBlocks& hinge : impl_->pattern.hinges) pass.add_hinge(hinge);
  impl_->finish(pass.energies, h);
  return impl_->system;
}

}  // namespace crease
