// SPDX-License-Identifier: MIT
// Generalised forces of the assembled system: oracles that do not use the assembly's own formulas.

#include <string>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "crease/dynamics/assemble.hpp"
#include "crease/geometry/triangle.hpp"
#include "support/dynamics_cases.hpp"

namespace crease {
namespace {

using testing::folded_cloth;
using testing::random_cloth;
using testing::Rng;

constexpr double h = 0.01;
const DynamicsOptions weightless{.gravity = Vec3::Zero(), .velocity_terms = false};

Material membrane_only(double youngs = 30) {
  return {.density = 0.2, .youngs = youngs, .poisson = 0.3, .bending = 0};
}

VecX force(const Cloth& cloth, const Material& material, const DynamicsOptions& options) {
  Assembler assembler;
  return assembler.assemble(cloth, make_dof_map(cloth), material, options, h, false).force;
}

// Moves one unknown of one vertex: 0..2 world, 3..4 material.
Cloth moved(Cloth cloth, int vertex, int k, double step) {
  if (k < 3) {
    cloth.mesh.x[vertex][k] += step;
  } else {
    cloth.mesh.X[vertex][k - 3] += step;
  }
  return cloth;
}

// -d(total energy)/dq by differences, against the assembled force, at every unknown.
void expect_force_is_minus_gradient(const Cloth& cloth, const Material& material, const DynamicsOptions& options) {
  const DofMap dofs = make_dof_map(cloth);
  const VecX f = force(cloth, material, options);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    for (int k = 0; k < (dofs.is_eol(v) ? 5 : 3); ++k) {
      const auto energy = [&](double step) {
        const Energies e = measure_energies(moved(cloth, v, k, step), material, options.gravity);
        return e.membrane + e.bending + e.gravitational;
      };
      // Elements of 0.15 m: truncation (3e-4/.15)^4 = 2e-11; rounding 1e-15 J/3e-4 m.
      EXPECT_NEAR(f[dofs.start[v] + k], -testing::central_difference(energy, 3e-4),
                  1e-8 * (1 + f.cwiseAbs().maxCoeff()))
          << "vertex " << v << " unknown " << k;
    }
  }
}

// On X this holds only with the term -psi A g_i that the paper leaves out.
TEST(AssembledForce, OfMembraneIsMinusEnergyGradientInBothSpaces) {
  expect_force_is_minus_gradient(random_cloth(31, 5, 0.03, 2), membrane_only(), weightless);
}

TEST(AssembledForce, OfGravityIsMinusEnergyGradientInBothSpaces) {
  const DynamicsOptions heavy{.gravity = {0.3, -0.5, -9.81}, .velocity_terms = false};
  expect_force_is_minus_gradient(random_cloth(32, 5, 0.1, 2), membrane_only(1e-9), heavy);
}

TEST(AssembledForce, OfBendingIsMinusEnergyGradientInTheWorld) {
  Material stiff = membrane_only();
  stiff.bending = 0.05;
  expect_force_is_minus_gradient(random_cloth(33, 5, 0.03, 0), stiff, weightless);
}

TEST(AssembledForce, OfElasticityHasNoResultant) {
  Material stiff = membrane_only();
  stiff.bending = 0.05;
  const Cloth cloth = random_cloth(34, 6, 0.05, 2);
  const DofMap dofs = make_dof_map(cloth);
  const VecX f = force(cloth, stiff, weightless);
  Vec3 total = Vec3::Zero(), torque = Vec3::Zero();
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    total += f.segment<3>(dofs.x(v));
    torque += cloth.mesh.x[v].cross(f.segment<3>(dofs.x(v)));
  }
  EXPECT_LT(total.norm(), 1e-13 * f.norm());
  EXPECT_LT(torque.norm(), 1e-13 * f.norm());
}

// A hinge's fold energy ~ theta^2/area would pin the fold to the mesh if it were differentiated with respect to X.
TEST(AssembledForce, OfBendingPushesAnUnstretchedFoldNowhere) {
  for (const double degrees : {1.0, 45.0, 90.0, 170.0}) {
    SCOPED_TRACE(std::to_string(degrees) + " degrees");
    const Cloth cloth = folded_cloth(6, degrees * M_PI / 180, 35);
    const DofMap dofs = make_dof_map(cloth);
    Material stiff = membrane_only();
    stiff.bending = 1;
    const VecX f = force(cloth, stiff, weightless);
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      // Rounding of the membrane, E = 30 N/m, and of hinge forces of up to 1e2 N.
      if (dofs.is_eol(v)) {
        EXPECT_LT(f.segment<2>(dofs.X(v)).norm(), 1e-12 * f.norm());
      }
    }
  }
}

// Irregular patch under an affine map: stresses are constant, so inner vertices feel nothing, in either space.
TEST(AssembledForce, PassesThePatchTest) {
  Cloth cloth = random_cloth(36, 5, 0, 1);
  const DofMap dofs = make_dof_map(cloth);
  Material stiff = membrane_only();
  stiff.bending = 0.05;
  const VecX f = force(cloth, stiff, weightless);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    if (cloth.mesh.is_border_vertex(v)) continue;
    EXPECT_LT(f.segment(dofs.start[v], 5).norm(), 1e-13 * f.norm());
  }
}

// -- the flat cloth, where an Eulerian vertex can move in its own plane and change nothing
// ------------------------------

// Sheet with density 1 whose elasticity is too weak to be seen beside the inertia: H = M.
MatX inertia(const Cloth& cloth) {
  const Material inert{.density = 1, .youngs = 1e-30, .poisson = 0, .bending = 0};
  Assembler assembler;
  return assembler.assemble(cloth, make_dof_map(cloth), inert, weightless, h, false).H;
}

VecX eigenvalues(const MatX& M) {
  return Eigen::SelfAdjointEigenSolver<MatX>(M, Eigen::EigenvaluesOnly).eigenvalues();
}

int nullity_of_inertia(const Cloth& cloth) {
  const VecX values = eigenvalues(inertia(cloth));
  return static_cast<int>((values.array() < 1e-12 * values[values.size() - 1]).count());
}

TEST(FlatCloth, LeavesExactlyTwoFreeMotionsAnEulerianVertex) {
  const Cloth cloth = random_cloth(41, 5, 0, 1);
  EXPECT_EQ(nullity_of_inertia(cloth), 2 * cloth.n_eol());
  EXPECT_EQ(cloth.n_eol(), 16);
}

TEST(FoldedCloth, LeavesExactlyOneFreeMotionAVertexOnTheFold) {
  for (const double degrees : {5.0, 45.0, 90.0, 135.0}) {
    const Cloth cloth = folded_cloth(4, degrees * M_PI / 180, 42);
    EXPECT_EQ(nullity_of_inertia(cloth), cloth.n_eol()) << degrees << " degrees";
  }
  const Cloth flat = folded_cloth(4, 0, 42);
  EXPECT_EQ(nullity_of_inertia(flat), 2 * flat.n_eol());
}

// A sheet 1 x 1 of 4 x 4 squares, their diagonals alternating, folded about X = 1/2; the fold's inner vertices are EOL.
Cloth folded_checkerboard(double bend) {
  constexpr int n = 4;
  std::vector<Vec2> X;
  std::vector<Vec3> x;
  std::vector<std::array<int, 3>> faces;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      X.emplace_back(double(i) / n, double(j) / n);
      const double s = X.back().x() - 0.5, y = X.back().y();
      x.push_back(s <= 0 ? Vec3(s, y, 0) : Vec3(s * std::cos(bend), y, -s * std::sin(bend)));
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      if (i == n || j == n) continue;
      if ((i + j) % 2) {
        faces.insert(faces.end(), {{a, b, d}, {a, d, c}});
      } else {
        faces.insert(faces.end(), {{a, b, c}, {b, d, c}});
      }
    }
  }
  Cloth cloth = make_cloth(Mesh(X, x, faces));
  for (int j = 1; j < n; ++j) testing::make_eol(cloth, j * (n + 1) + n / 2);
  return cloth;
}

// Smallest over largest eigenvalue of the inertia under the tangent rule, its EOL vertices held besides in z, in x.
double conditioning(const Cloth& cloth, bool hold_z, bool hold_x) {
  const DofMap dofs = make_dof_map(cloth);
  std::vector<Eigen::Index> kept;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    for (int k = 0; k < (cloth.is_eol(v) ? 4 : 3); ++k) {  // unknown 4 runs along the fold: the tangent rule's
      if (cloth.is_eol(v) && ((k == 2 && hold_z) || (k == 0 && hold_x))) continue;
      kept.push_back(dofs.start[v] + k);
    }
  }
  const VecX values = eigenvalues(inertia(cloth)(kept, kept));
  return values[0] / values[values.size() - 1];
}

// Numbers from another program, in another language, whose inertia is checked by quadrature.
TEST(FoldedCloth, IsConditionedAsAnIndependentAssemblySays) {
  struct Row {
    double degrees, tangent_rule, one_normal, both_normals;
  };
  constexpr Row table[] = {
      {0.1, 6.836282238e-08, 1.360354768e-07, 0.0717469417}, {1, 6.836336113e-06, 1.360358615e-05, 0.0717469417},
      {5, 1.709410796e-04, 3.401128136e-04, 0.0717469417},   {15, 1.540917219e-03, 3.062648645e-03, 0.0717469417},
      {45, 1.406352692e-02, 2.761136181e-02, 0.0717469417},  {90, 5.097032760e-02, 5.628709738e-02, 0.0717469417},
      {135, 5.970136680e-02, 6.713074336e-02, 0.0717469417}, {179, 7.159374603e-02, 7.174692512e-02, 0.0717469417}};
  for (const Row& row : table) {
    SCOPED_TRACE(std::to_string(row.degrees) + " degrees");
    const Cloth cloth = folded_checkerboard(row.degrees * M_PI / 180);
    // Ten digits are given; an eigenvalue carries the rounding of the largest one, 1e-16 times some.
    EXPECT_NEAR(conditioning(cloth, false, false), row.tangent_rule, 1e-9 * row.tangent_rule + 1e-15);
    EXPECT_NEAR(conditioning(cloth, true, false), row.one_normal, 1e-9 * row.one_normal + 1e-15);
    EXPECT_NEAR(conditioning(cloth, true, true), row.both_normals, 1e-9 * row.both_normals);
  }
}

// (xdot, Xdot) = (F c, c) at a vertex of a flat, evenly stretched sheet renames material points. It must cost nothing,
// be resisted by nothing, and following it must change neither shape nor forces.
TEST(FlatCloth, DoesNotNoticeRelabelling) {
  Cloth cloth = random_cloth(43, 5, 0, 1);
  const DofMap dofs = make_dof_map(cloth);
  const Mat32 F = deformation_gradient(cloth.mesh, 0);
  Rng rng(43);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    cloth.V[v] = cloth.is_eol(v) ? rng.vec2(0.3) : Vec2(0, 0);
    cloth.v[v] = F * cloth.V[v];
  }
  Material stiff = membrane_only();
  stiff.bending = 0.05;
  const DynamicsOptions full{.gravity = {0.3, -0.5, -9.81}, .velocity_terms = true};
  Assembler assembler;
  const AssembledSystem before = assembler.assemble(cloth, dofs, stiff, full, h, false);
  EXPECT_LT(before.energies.kinetic, 1e-28);
  EXPECT_LT((before.H * gather_velocity(cloth, dofs)).norm(), 1e-14);
  EXPECT_LT((before.rhs - h * before.force).norm(), 1e-15);

  testing::advance(cloth, dofs, gather_velocity(cloth, dofs), 0.05);
  const AssembledSystem& after = assembler.assemble(cloth, dofs, stiff, full, h, true);
  EXPECT_NEAR(after.energies.membrane, before.energies.membrane, 1e-14);
  EXPECT_NEAR(after.energies.gravitational, before.energies.gravitational, 1e-14);
  DynamicsOptions no_gravity = full;
  no_gravity.gravity.setZero();
  const VecX f = assembler.assemble(cloth, dofs, stiff, no_gravity, h, true).force;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    if (dofs.is_eol(v)) {
      EXPECT_LT(f.segment<5>(dofs.start[v]).norm(), 1e-13 * f.norm());
    }
  }
}

// -- velocity terms
// ----------------------------------------------------------------------------------------------------

VecX velocity_terms(const Cloth& cloth) {
  DynamicsOptions with = weightless;
  with.velocity_terms = true;
  return force(cloth, membrane_only(), weightless) - force(cloth, membrane_only(), with);
}

TEST(VelocityTerms, AreZeroOnLagrangianClothAndWhereNoFoldMoves) {
  EXPECT_EQ(velocity_terms(random_cloth(51, 5, 0.05, 0)).norm(), 0);
  Cloth cloth = random_cloth(51, 5, 0.05, 2);
  for (Vec2& V : cloth.V) V.setZero();
  EXPECT_LT(velocity_terms(cloth).norm(), 1e-13);  // sums of terms of size 1
}

TEST(VelocityTerms, DoNotChangeInAMovingFrame) {
  Cloth cloth = random_cloth(52, 5, 0.05, 2);
  const VecX before = velocity_terms(cloth);
  for (Vec3& v : cloth.v) v += Vec3(7, -3, 11);
  EXPECT_LT((velocity_terms(cloth) - before).norm(), 1e-11 * before.norm());  // terms grow as 10^2
}

// A folded sheet that glides round its edge like a rigid lamina in the unfolded plane with the velocity c across the
// fold: material turns the corner and leaves rho c^2 (a - b) of momentum per length behind, on the fold alone.
TEST(VelocityTerms, CarryTheMomentumThatCrossesTheFold) {
  const double c = 1.3, angle = M_PI / 2;
  Cloth cloth = folded_cloth(6, angle, 53);
  const Vec3 a(1, 0, 0), b(std::cos(angle), 0, -std::sin(angle));
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    const double s = cloth.mesh.X[v].x() - 0.5;
    if (std::abs(s) < 1e-12) {
      testing::make_eol(cloth, v);  // the two ends of the fold too
      cloth.V[v] = {-c, 0};
      cloth.v[v].setZero();
    } else {
      cloth.v[v] = c * (s < 0 ? a : b);
    }
  }
  const DofMap dofs = make_dof_map(cloth);
  const VecX C = velocity_terms(cloth);
  Vec3 total = Vec3::Zero();
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    const Vec3 here = C.segment<3>(dofs.x(v));
    total += here;
    if (!dofs.is_eol(v)) {
      EXPECT_LT(here.norm(), 1e-13);
    }
  }
  EXPECT_LT((total + membrane_only().density * c * c * (a - b)).norm(), 1e-13);  // fold of length 1
  const double mass = membrane_only().density;
  EXPECT_NEAR(measure_energies(cloth, membrane_only(), Vec3::Zero()).kinetic, 0.5 * mass * c * c, 1e-14);
}

}  // namespace
}  // namespace crease
