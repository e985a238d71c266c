// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "crease/dynamics/assemble.hpp"
#include "support/seams.hpp"

namespace crease {
namespace {

const Material material{.density = 0.2, .youngs = 30, .poisson = 0.3, .bending = 1e-3, .damping = 0.01};
constexpr double h = 0.02;

// A crumpled, moving sheet and the same one cut into panels, laid elsewhere in material space and sewn: isotropic cloth
// does not know the difference, in the membrane nor in the hinges over the seams.
struct Pair {
  Cloth whole, sewn;
  std::vector<int> of_whole;

  explicit Pair(const std::function<int(const Vec2&)>& panel) {
    Mesh mesh = support::grid(GridPattern::Cross, 6, 6);
    support::Rng rng(7);
    support::crumple(mesh, rng, 0.02);
    support::CutSheet cut = support::cut_and_sew(mesh, panel);
    of_whole = cut.whole;
    whole = make_cloth(mesh);
    sewn = make_cloth(cut.mesh);
    for (Vec3& v : whole.v)
      v = Vec3(support::uniform(rng, -1, 1), support::uniform(rng, -1, 1), support::uniform(rng, -1, 1));
    for (std::size_t i = 0; i < of_whole.size(); ++i) sewn.v[i] = whole.v[of_whole[i]];
  }
  // Takes unknowns of the whole sheet to those of the sewn one: a permutation.
  MatX map(const DofMap& from, const DofMap& to) const {
    MatX P = MatX::Zero(to.size(), from.size());
    for (std::size_t i = 0; i < of_whole.size(); ++i)
      P.block<3, 3>(to.x(static_cast<int>(i)), from.x(of_whole[i])).setIdentity();
    return P;
  }
};

TEST(SewnCloth, HasTheSystemAndTheEnergiesOfOneSheet) {
  for (const int kind : {0, 1}) {
    SCOPED_TRACE(kind);
    const Pair cloths(kind == 0 ? std::function<int(const Vec2&)>([](const Vec2& c) { return c.x() < 0.6 ? 0 : 1; })
                                : [](const Vec2& c) { return (c.x() < 0.6 ? 0 : 1) + (c.y() < 0.6 ? 0 : 2); });
    ASSERT_TRUE(cloths.sewn.mesh.has_seams());
    ASSERT_EQ(validate(cloths.sewn), std::nullopt);
    const DofMap dofs = make_dof_map(cloths.whole), sewn_dofs = make_dof_map(cloths.sewn);
    ASSERT_EQ(dofs.size(), sewn_dofs.size());
    Assembler assembler, sewn_assembler;
    const AssembledSystem& one = assembler.assemble(cloths.whole, dofs, material, {}, h, false);
    const AssembledSystem& other = sewn_assembler.assemble(cloths.sewn, sewn_dofs, material, {}, h, false);
    const MatX P = cloths.map(dofs, sewn_dofs), expected = P * MatX(one.H) * P.transpose();
    // Rounding of material positions that were turned and moved by metres, in cotangents and areas.
    EXPECT_LT((MatX(other.H) - expected).norm(), 1e-11 * expected.norm());
    EXPECT_EQ((MatX(other.H) - MatX(other.H).transpose()).norm(), 0);
    EXPECT_LT((other.rhs - P * one.rhs).norm(), 1e-11 * one.rhs.norm());
    EXPECT_NEAR(other.energies.bending, one.energies.bending, 1e-11 * one.energies.bending);
    const Energies a = measure_energies(cloths.whole, material, Vec3(0, 0, -9.81)),
                   b = measure_energies(cloths.sewn, material, Vec3(0, 0, -9.81));
    EXPECT_NEAR(a.bending, b.bending, 1e-11 * a.bending);
    EXPECT_NEAR(a.total(), b.total(), 1e-11 * std::abs(a.total()));
  }
}

// Vertices that are tied share columns, so they must not be shared out to two threads.
TEST(SewnCloth, HasTheSameSystemOnAnyNumberOfThreads) {
  Mesh mesh = support::grid(GridPattern::Cross, 16, 16);
  support::Rng rng(8);
  support::crumple(mesh, rng, 0.005);
  const Cloth cloth = make_cloth(support::cut_and_sew(mesh, [](const Vec2& c) { return c.x() < 0.5 ? 0 : 1; }).mesh);
  ASSERT_TRUE(cloth.mesh.has_seams());
  const DofMap dofs = make_dof_map(cloth);
  Assembler one, three(3);
  const AssembledSystem& expected = one.assemble(cloth, dofs, material, {}, h, false);
  const AssembledSystem& system = three.assemble(cloth, dofs, material, {}, h, false);
  EXPECT_EQ((MatX(system.H) - MatX(expected.H)).norm(), 0);
  EXPECT_EQ(system.rhs, expected.rhs);
}

// An Eulerian vertex beside a seam: force is minus the energy's gradient in x, also through the hinge over the seam.
TEST(SewnCloth, ForceIsMinusTheEnergyGradientBesideASeam) {
  Pair cloths([](const Vec2& c) { return c.x() < 0.6 ? 0 : 1; });
  Cloth& cloth = cloths.sewn;
  for (Vec3& v : cloth.v) v.setZero();
  const Mesh& mesh = cloth.mesh;
  int beside = Mesh::none;
  for (int k = 0; k < 3 * mesh.face_slots(); ++k)
    if (mesh.seam_twin(k) != Mesh::none && !mesh.is_border_vertex(mesh.opposite(k))) beside = mesh.opposite(k);
  ASSERT_NE(beside, Mesh::none);
  cloth.feature[beside] = {0, FeatureKind::Edge, 0};
  const DofMap dofs = make_dof_map(cloth);
  DynamicsOptions options;
  options.gravity.setZero();
  Assembler assembler;
  const VecX force = assembler.assemble(cloth, dofs, material, options, h, false).force;
  for (const int v : {beside, 0, mesh.n_vertices() / 2}) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto energy_at = [&](double offset) {
        Cloth moved = cloth;
        int u = v;
        do {
          moved.mesh.x[u][axis] += offset;
          u = mesh.tied(u);
        } while (u != v);
        const Energies e = measure_energies(moved, material, Vec3::Zero());
        return e.membrane + e.bending;
      };
      constexpr double d = 1e-5;
      const double expected = -(energy_at(d) - energy_at(-d)) / (2 * d);
      EXPECT_NEAR(force[dofs.x(v) + axis], expected, 1e-6 * (1 + std::abs(expected)));  // central differences: d^2
    }
  }
}

}  // namespace
}  // namespace crease
