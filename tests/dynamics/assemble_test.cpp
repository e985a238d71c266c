// SPDX-License-Identifier: MIT
#include "crease/dynamics/assemble.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "crease/dynamics/bending.hpp"
#include "crease/dynamics/inertia.hpp"
#include "crease/dynamics/membrane.hpp"
#include "crease/geometry/triangle.hpp"
#include "support/dynamics_cases.hpp"

namespace crease {
namespace {

using testing::random_cloth;

const Material material{.density = 0.2, .youngs = 30, .poisson = 0.3, .bending = 1e-3, .damping = 0.01};
const DynamicsOptions options{.gravity = {0.3, -0.5, -9.81}, .velocity_terms = true};
constexpr double h = 0.02;

// Rows of an element's 5 m unknowns (all x first, then all X) in qdot; -1 where a Lagrangian vertex has none.
std::vector<int> element_rows(const DofMap& dofs, const std::vector<int>& vertices) {
  std::vector<int> rows;
  for (const int v : vertices) {
    for (int k = 0; k < 3; ++k) rows.push_back(dofs.x(v) + k);
  }
  for (const int v : vertices) {
    for (int k = 0; k < 2; ++k) rows.push_back(dofs.is_eol(v) ? dofs.X(v) + k : -1);
  }
  return rows;
}

void add_element(const MatX& element, const std::vector<int>& rows, MatX& total) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < rows.size(); ++j) {
      if (rows[i] >= 0 && rows[j] >= 0) total(rows[i], rows[j]) += element(i, j);
    }
  }
}

// J^T K J with J = (I, -F) for every vertex of an element.
MatX mapped(const MatX& K, const Mat32& F) {
  const Eigen::Index m = K.rows() / 3;
  MatX J = MatX::Zero(3 * m, 5 * m);
  for (Eigen::Index i = 0; i < m; ++i) {
    J.block(3 * i, 3 * i, 3, 3).setIdentity();
    J.block(3 * i, 3 * m + 2 * i, 3, 2) = -F;
  }
  return J.transpose() * K * J;
}

struct DenseSystem {
  MatX M, K;
  VecX C;
};

// The textbook way: whole elements, dense matrices.
DenseSystem dense_system(const Cloth& cloth, const DofMap& dofs) {
  const Mesh& mesh = cloth.mesh;
  DenseSystem dense{MatX::Zero(dofs.size(), dofs.size()), MatX::Zero(dofs.size(), dofs.size()),
                    VecX::Zero(dofs.size())};
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const auto& [a, b, c] = mesh.face(f);
    const auto X = material_corners(mesh, f);
    const auto x = world_corners(mesh, f);
    const auto rows = element_rows(dofs, {a, b, c});
    add_element(eol_inertia(X, x, material.density), rows, dense.M);
    add_element(mapped(membrane_element(X, x, material).stiffness, deformation_gradient(mesh, f)), rows, dense.K);
    const Vec15 C = eol_velocity_terms(
        {X, x, {cloth.V[a], cloth.V[b], cloth.V[c]}, {cloth.v[a], cloth.v[b], cloth.v[c]}}, material.density);
    for (int i = 0; i < 15; ++i) {
      if (rows[i] >= 0) dense.C[rows[i]] += C[i];
    }
  }
  for (const int e : mesh.edges()) {
    if (mesh.is_border(e)) continue;
    const std::vector<int> v{mesh.from(e), mesh.to(e), mesh.opposite(e), mesh.opposite(mesh.twin(e))};
    const BendingElement bending =
        bending_element({mesh.X[v[0]], mesh.X[v[1]], mesh.X[v[2]], mesh.X[v[3]]}, material.bending);
    MatX K = MatX::Zero(12, 12);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j)
        K.block(3 * i, 3 * j, 3, 3) = bending.c * bending.k[i] * bending.k[j] * Mat3::Identity();
    }
    const Mat32 F =
        0.5 * (deformation_gradient(mesh, Mesh::face_of(e)) + deformation_gradient(mesh, Mesh::face_of(mesh.twin(e))));
    add_element(mapped(K, F), element_rows(dofs, v), dense.K);
  }
  return dense;
}

TEST(Assembler, MatrixEqualsDenseAssemblyOfTheElements) {
  for (const int eol_every : {0, 1, 3}) {
    SCOPED_TRACE("every " + std::to_string(eol_every) + "th interior vertex Eulerian");
    const Cloth cloth = random_cloth(11, 5, 0.05, eol_every);
    const DofMap dofs = make_dof_map(cloth);
    Assembler assembler;
    const AssembledSystem& system = assembler.assemble(cloth, dofs, material, options, h, false);
    const DenseSystem dense = dense_system(cloth, dofs);
    const MatX expected = dense.M + (h * h + h * material.damping) * dense.K;
    const MatX H(system.H);
    EXPECT_LT((H - expected).norm(), 1e-13 * expected.norm());
    EXPECT_EQ((H - H.transpose()).norm(), 0);  // exactly symmetric: both triangles are sums of the same numbers
    EXPECT_TRUE(system.H.isCompressed());
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatX>(H, Eigen::EigenvaluesOnly).eigenvalues()[0], 0);
  }
}

TEST(Assembler, RightHandSideIsMomentumPlusImpulse) {
  const Cloth cloth = random_cloth(12, 5, 0.05, 2);
  const DofMap dofs = make_dof_map(cloth);
  const DenseSystem dense = dense_system(cloth, dofs);
  Assembler assembler;
  const AssembledSystem full = assembler.assemble(cloth, dofs, material, options, h, false);
  DynamicsOptions paper = options;
  paper.velocity_terms = false;
  const AssembledSystem without = assembler.assemble(cloth, dofs, material, paper, h, true);
  const VecX momentum = dense.M * gather_velocity(cloth, dofs);
  EXPECT_LT((full.rhs - momentum - h * full.force).norm(), 1e-13 * full.rhs.norm());
  EXPECT_LT((without.rhs - momentum - h * without.force).norm(), 1e-13 * full.rhs.norm());
  EXPECT_LT((without.force - full.force - dense.C).norm(), 1e-13 * full.force.norm());
  EXPECT_EQ((MatX(without.H) - MatX(full.H)).norm(), 0);
}

TEST(Assembler, KeptPatternGivesTheBytesOfAFreshOne) {
  Cloth cloth = random_cloth(13, 6, 0.05, 3);
  const DofMap dofs = make_dof_map(cloth);
  Assembler kept;
  kept.assemble(cloth, dofs, material, options, h, false);
  testing::advance(cloth, dofs, gather_velocity(cloth, dofs), 1e-3);
  const AssembledSystem& again = kept.assemble(cloth, dofs, material, options, h, true);
  Assembler fresh;
  const AssembledSystem& first = fresh.assemble(cloth, dofs, material, options, h, false);
  EXPECT_EQ((MatX(again.H) - MatX(first.H)).norm(), 0);
  EXPECT_EQ(again.H.nonZeros(), first.H.nonZeros());
  EXPECT_EQ(again.rhs, first.rhs);
  EXPECT_EQ(again.force, first.force);
}

// Enough faces to be shared out, and a second step in the pattern kept.
TEST(Assembler, GivesTheSameBytesOnAnyNumberOfThreads) {
  const Cloth cloth = random_cloth(14, 18, 0.02, 5);
  const DofMap dofs = make_dof_map(cloth);
  Assembler one;
  const AssembledSystem& expected = one.assemble(cloth, dofs, material, options, h, false);
  for (const int threads : {2, 3, 8}) {
    SCOPED_TRACE(threads);
    Assembler several(threads);
    for (const bool same_topology : {false, true}) {
      const AssembledSystem& system = several.assemble(cloth, dofs, material, options, h, same_topology);
      EXPECT_EQ((MatX(system.H) - MatX(expected.H)).norm(), 0);
      EXPECT_EQ(system.rhs, expected.rhs);
      EXPECT_EQ(system.force, expected.force);
      EXPECT_EQ(system.energies.kinetic, expected.energies.kinetic);
      EXPECT_EQ(system.energies.membrane, expected.energies.membrane);
      EXPECT_EQ(system.energies.bending, expected.energies.bending);
      EXPECT_EQ(system.energies.gravitational, expected.energies.gravitational);
      EXPECT_EQ(system.energies.momentum, expected.energies.momentum);
      EXPECT_EQ(system.energies.angular_momentum, expected.energies.angular_momentum);
    }
  }
  EXPECT_THROW(Assembler(0), std::invalid_argument);
}

// Sizes that leave lanes of the last batch over; the first is less than one batch.
TEST(Assembler, GivesTheSameBytesWithTheKernelsOfAnyProcessor) {
  const std::vector<ElementKernelSet> available = available_element_kernels();
  if (available.size() == 1) GTEST_SKIP() << "this processor runs only the generic kernels";
  for (const int cells : {1, 3, 5}) {
    const Cloth cloth = random_cloth(16, cells, 0.05, 1);
    const DofMap dofs = make_dof_map(cloth);
    Assembler generic(1, ElementKernelSet::Generic);
    const AssembledSystem& expected = generic.assemble(cloth, dofs, material, options, h, false);
    for (const ElementKernelSet kernels : available) {
      SCOPED_TRACE(static_cast<int>(kernels));
      Assembler assembler(1, kernels);
      const AssembledSystem& system = assembler.assemble(cloth, dofs, material, options, h, false);
      EXPECT_EQ((MatX(system.H) - MatX(expected.H)).norm(), 0);
      EXPECT_EQ(system.rhs, expected.rhs);
      EXPECT_EQ(system.force, expected.force);
      EXPECT_EQ(system.energies.total(), expected.energies.total());
      EXPECT_EQ(system.energies.angular_momentum, expected.energies.angular_momentum);
    }
  }
}

TEST(Assembler, RefusesTheKernelsOfAnotherProcessor) {
  const std::vector<ElementKernelSet> available = available_element_kernels();
  for (const ElementKernelSet kernels : {ElementKernelSet::Avx2, ElementKernelSet::Avx512}) {
    if (std::find(available.begin(), available.end(), kernels) == available.end()) {
      EXPECT_THROW(Assembler(1, kernels), std::invalid_argument);
    } else {
      EXPECT_NO_THROW(Assembler(1, kernels));
    }
  }
}

TEST(Assembler, LeavesFlapCouplingsOutWithoutBending) {
  const Cloth cloth = make_cloth(make_grid({.cells = {6, 5}, .pattern = GridPattern::Right}));
  const DofMap dofs = make_dof_map(cloth);
  Material limp = material;
  limp.bending = 0;
  Assembler assembler;
  // One block a vertex and two an edge; bending adds two a hinge, since no two hinges of this grid share their flaps.
  // The change of pattern is noticed unasked.
  const Mesh& mesh = cloth.mesh;
  const auto edges = static_cast<Eigen::Index>(mesh.edges().size());
  const Eigen::Index hinges = 3 * mesh.n_faces() - edges;
  EXPECT_EQ(assembler.assemble(cloth, dofs, limp, options, h, false).H.nonZeros(), 9 * (mesh.n_vertices() + 2 * edges));
  EXPECT_EQ(assembler.assemble(cloth, dofs, material, options, h, true).H.nonZeros(),
            9 * (mesh.n_vertices() + 2 * edges + 2 * hinges));
}

TEST(Assembler, RefusesWhatItCannotUse) {
  const Cloth cloth = random_cloth(15, 3, 0.05, 0);
  const DofMap dofs = make_dof_map(cloth);
  Assembler assembler;
  EXPECT_THROW(assembler.assemble(cloth, dofs, material, options, 0, false), std::invalid_argument);
  EXPECT_THROW(assembler.assemble(cloth, dofs, material, options, std::numeric_limits<double>::quiet_NaN(), false),
               std::invalid_argument);
  EXPECT_THROW(assembler.assemble(cloth, DofMap{{0, 3}, {}}, material, options, h, false), std::invalid_argument);
  for (const auto member :
       {&Material::density, &Material::youngs, &Material::poisson, &Material::bending, &Material::damping}) {
    for (const double wrong : {-1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
      Material broken = material;
      broken.*member = wrong;
      EXPECT_THROW(assembler.assemble(cloth, dofs, broken, options, h, false), std::invalid_argument);
    }
  }
}

// -- energies and momenta
// ----------------------------------------------------------------------------------------------

TEST(Energies, AreThoseOfTheAssembledState) {
  const Cloth cloth = random_cloth(21, 5, 0.05, 2);
  const DofMap dofs = make_dof_map(cloth);
  Assembler assembler;
  const AssembledSystem& system = assembler.assemble(cloth, dofs, material, options, h, false);
  const Energies energies = measure_energies(cloth, material, options.gravity);
  EXPECT_EQ(energies.kinetic, system.energies.kinetic);
  EXPECT_EQ(energies.membrane, system.energies.membrane);
  EXPECT_NEAR(energies.bending, system.energies.bending, 1e-14 * energies.bending);
  EXPECT_EQ(energies.gravitational, system.energies.gravitational);
  EXPECT_EQ(energies.momentum, system.energies.momentum);
  EXPECT_EQ(energies.angular_momentum, system.energies.angular_momentum);
}

TEST(Energies, KineticPartAndMomentaBelongToTheInertia) {
  const Cloth cloth = random_cloth(22, 5, 0.05, 2);
  const DofMap dofs = make_dof_map(cloth);
  const MatX M = dense_system(cloth, dofs).M;
  const VecX q_dot = gather_velocity(cloth, dofs);
  const Energies energies = measure_energies(cloth, material, options.gravity);
  EXPECT_NEAR(energies.kinetic, 0.5 * q_dot.dot(M * q_dot), 1e-13 * energies.kinetic);
  for (int axis = 0; axis < 3; ++axis) {
    VecX translation = VecX::Zero(dofs.size()), rotation = VecX::Zero(dofs.size());
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      translation.segment<3>(dofs.x(v)) = Vec3::Unit(axis);
      rotation.segment<3>(dofs.x(v)) = Vec3::Unit(axis).cross(cloth.mesh.x[v]);
    }
    EXPECT_NEAR(energies.momentum[axis], translation.dot(M * q_dot), 1e-13);
    EXPECT_NEAR(energies.angular_momentum[axis], rotation.dot(M * q_dot), 1e-13);
  }
}

TEST(Energies, RefuseAnInvalidMaterial) {
  const Cloth cloth = random_cloth(23, 3, 0.05, 0);
  Material broken = material;
  broken.density = 0;
  EXPECT_THROW(measure_energies(cloth, broken, Vec3::Zero()), std::invalid_argument);
}

}  // namespace
}  // namespace crease
