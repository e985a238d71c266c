// SPDX-License-Identifier: MIT
// The equations of motion stepped and settled without contact, against exact solutions.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "crease/dynamics/assemble.hpp"
#include "support/dynamics_cases.hpp"

namespace crease {
namespace {

using testing::random_cloth;

constexpr double g = 9.81;

// The linearly implicit step falls by x0 + v0 t - g t (t + h)/2 exactly, on any mesh, Eulerian vertices or not: they
// follow because M (g, 0) is the gravity force, and no Xdot arises.
TEST(FreeFall, IsExactOnAnyMesh) {
  const Material limp{.density = 0.1, .youngs = 1e-20, .poisson = 0.3, .bending = 0};
  constexpr double h = 0.01;
  constexpr int steps = 50;
  for (const int eol_every : {0, 1, 3}) {
    SCOPED_TRACE("every " + std::to_string(eol_every) + "th interior vertex Eulerian");
    Cloth cloth = random_cloth(61, 5, 0.15, eol_every);
    const Vec3 v0(0.4, -0.3, 1.2);
    std::fill(cloth.v.begin(), cloth.v.end(), v0);
    std::fill(cloth.V.begin(), cloth.V.end(), Vec2::Zero());
    const Cloth start = cloth;
    const DofMap dofs = make_dof_map(cloth);
    const MatX all = testing::all_motions(dofs);
    Assembler assembler;
    for (int k = 0; k < steps; ++k) {
      testing::advance(cloth, dofs, testing::solve_step(assembler.assemble(cloth, dofs, limp, {}, h, k > 0), all), h);
    }
    const double t = steps * h;
    const Vec3 path = v0 * t - Vec3(0, 0, 0.5 * g * t * (t + h));
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      // Rounding 1e-16 a solve times the condition number of M, up to 1e4 with Eulerian vertices; measured 1e-14.
      EXPECT_LT((cloth.mesh.x[v] - start.mesh.x[v] - path).norm(), 1e-12);
      EXPECT_LT((cloth.mesh.X[v] - start.mesh.X[v]).norm(), 1e-12);
    }
  }
}

TEST(Stepping, KeepsLinearMomentumAndNeverGainsEnergy) {
  const Material material{.density = 0.1, .youngs = 100, .poisson = 0.3, .bending = 1e-4, .damping = 1e-3};
  const DynamicsOptions options{.gravity = Vec3::Zero()};
  Cloth cloth = random_cloth(62, 6, 0.02, 0);
  const DofMap dofs = make_dof_map(cloth);
  const MatX all = testing::all_motions(dofs);
  Assembler assembler;
  const Energies start = measure_energies(cloth, material, options.gravity);
  double energy = start.total();
  for (int k = 0; k < 200; ++k) {
    testing::advance(cloth, dofs,
                     testing::solve_step(assembler.assemble(cloth, dofs, material, options, 0.005, k > 0), all), 0.005);
    const Energies now = measure_energies(cloth, material, options.gravity);
    EXPECT_LT((now.momentum - start.momentum).norm(), 1e-13);
    EXPECT_LT(now.total(), energy * (1 + 1e-10)) << "step " << k;
    energy = now.total();
  }
}

// Backward Euler takes a mode of frequency w from (q, qdot) to the amplitude sqrt(q^2 + (qdot/w)^2)/sqrt(1 + (w h)^2).
TEST(Stepping, DampsEveryModeByItsFrequencyAlone) {
  const Material material{.density = 0.1, .youngs = 100, .poisson = 0.3, .bending = 0};
  const DynamicsOptions options{.gravity = Vec3::Zero()};
  const Cloth rest = make_cloth(make_grid({.cells = {4, 3}, .pattern = GridPattern::Irregular, .seed = 3}));
  const DofMap dofs = make_dof_map(rest);
  const MatX all = testing::all_motions(dofs);
  Assembler assembler;
  const MatX H1 = assembler.assemble(rest, dofs, material, options, 1.0, false).H;
  const MatX H2 = assembler.assemble(rest, dofs, material, options, 2.0, true).H;
  const MatX K = (H2 - H1) / 3, M = H1 - K;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatX> modes(K, M);
  for (const Eigen::Index mode : {dofs.size() - 1, dofs.size() - 10, dofs.size() - 25}) {
    const double w = std::sqrt(modes.eigenvalues()[mode]);
    const VecX shape = modes.eigenvectors().col(mode);
    for (const double wh : {0.1, 1.0, 10.0}) {
      SCOPED_TRACE("mode " + std::to_string(mode) + ", w h = " + std::to_string(wh));
      const double h = wh / w;
      constexpr int steps = 4;
      // Small enough for the quadratic terms, large enough for the rounding of positions, 1e-16 against 1e-8.
      constexpr double amplitude = 1e-8;
      Cloth cloth = rest;
      for (int v = 0; v < cloth.mesh.n_vertices(); ++v) cloth.mesh.x[v] += amplitude * shape.segment<3>(dofs.x(v));
      for (int k = 0; k < steps; ++k) {
        testing::advance(cloth, dofs,
                         testing::solve_step(assembler.assemble(cloth, dofs, material, options, h, true), all), h);
      }
      VecX offset(dofs.size());
      for (int v = 0; v < cloth.mesh.n_vertices(); ++v) offset.segment<3>(dofs.x(v)) = cloth.mesh.x[v] - rest.mesh.x[v];
      const double q = shape.dot(M * offset), q_dot = shape.dot(M * gather_velocity(cloth, dofs));
      EXPECT_NEAR(std::hypot(q, q_dot / w) / amplitude, std::pow(1 + wh * wh, -0.5 * steps), 1e-6);
    }
  }
}

// -- statics
// -----------------------------------------------------------------------------------------------------------

// A strip hung from its end, poisson 0: r(s) = s + rho g/E (L s - s^2/2) at any strain. Linear elements are exact at
// the rows of a mesh with straight rows, but only for the mean of a row: where the corners of the lowest row have
// unequal shares of its mass, single vertices deviate. Rows that move as one have only that mean.
TEST(HangingStrip, IsExactAtTheRows) {
  const double L = 1;
  for (const double E : {10.0, 100.0, 1e4}) {
    SCOPED_TRACE("E = " + std::to_string(E));
    const Material material{.density = 0.1, .youngs = E, .poisson = 0, .bending = 0};
    constexpr int rows = 8;
    Cloth cloth = make_cloth(make_grid({.size = {0.2, L}, .cells = {2, rows - 1}, .pattern = GridPattern::Right}));
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {  // uneven rows; s = 0, the clamp, is X.y = 0
      double& s = cloth.mesh.X[v].y();
      s += 0.05 * std::sin(2 * std::numbers::pi * s / L);
    }
    testing::map_world(cloth, [](const Vec2& P) { return Vec3(P.x(), 0, -P.y()); });
    const DofMap dofs = make_dof_map(cloth);
    MatX rows_together = MatX::Zero(dofs.size(), rows - 1);
    for (int v = 3; v < cloth.mesh.n_vertices(); ++v) rows_together(dofs.x(v) + 2, v / 3 - 1) = 1;
    ASSERT_TRUE(testing::settle(cloth, material, rows_together, 1e3, 1e-11, 5));
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      const double s = cloth.mesh.X[v].y();
      EXPECT_NEAR(-cloth.mesh.x[v].z(), s + material.density * g / E * (L * s - 0.5 * s * s), 1e-10);
    }
  }
}

// The same strip with all its unknowns free: the mean of each row keeps the exact place.
TEST(HangingStrip, IsExactInTheMeanOfEveryRowWhenFree) {
  const double L = 1, E = 1e3;
  const Material material{.density = 0.1, .youngs = E, .poisson = 0, .bending = 0};
  Cloth cloth = make_cloth(make_grid({.size = {0.2, L}, .cells = {2, 8}, .pattern = GridPattern::Right}));
  testing::map_world(cloth, [](const Vec2& P) { return Vec3(P.x(), 0, -P.y()); });
  const MatX hung = testing::free_motions(cloth, make_dof_map(cloth), [](const Vec2& P) { return P.y() == 0; });
  ASSERT_TRUE(testing::settle(cloth, material, hung, 10, 1e-12, 100));
  for (int row = 0; row <= 8; ++row) {
    const double s = L * row / 8;
    const double mean =
        0.25 * cloth.mesh.x[3 * row].z() + 0.5 * cloth.mesh.x[3 * row + 1].z() + 0.25 * cloth.mesh.x[3 * row + 2].z();
    // The corners' unequal shares turn the lowest elements by rho g l/E ~ 1e-4 rad, an effect of second order.
    EXPECT_NEAR(-mean, s + material.density * g / E * (L * s - 0.5 * s * s), 1e-8);
  }
}

// Elastic catenary between two level clamps, natural length 1 [IRVINE81]: with H the horizontal tension and V = w L/2,
// span = L H/E + 2 H/w asinh(V/H), sag = V L/(4 E) + H/w (sqrt(1 + (V/H)^2) - 1).
double catenary_sag(double span, double E, double w) {
  const double V = 0.5 * w;
  double low = 1e-6, high = 1e3;
  for (int k = 0; k < 200; ++k) {
    const double H = 0.5 * (low + high);
    (H / E + 2 * H / w * std::asinh(V / H) < span ? low : high) = H;
  }
  return V / (4 * E) + low / w * (std::sqrt(1 + V * V / (low * low)) - 1);
}

TEST(Catenary, SagsAsInTheClosedForm) {
  EXPECT_NEAR(catenary_sag(0.8, 100, 0.1 * g), 0.2686841226, 1e-9);  // against a chain of bars, extrapolated
  constexpr int n = 40;
  for (const auto& [span, E] : {std::pair{0.8, 10.0}, {0.8, 100.0}, {0.95, 100.0}, {1.0, 100.0}}) {
    SCOPED_TRACE("span " + std::to_string(span) + ", E " + std::to_string(E));
    const Material material{.density = 0.1, .youngs = E, .poisson = 0, .bending = 0};
    Cloth cloth = make_cloth(make_grid({.size = {1, 0.05}, .cells = {n, 1}, .pattern = GridPattern::Right}));
    testing::map_world(cloth, [&](const Vec2& P) {
      return Vec3(span * P.x(), P.y(), -2 * (1 - span) * std::sin(std::numbers::pi * P.x()));
    });
    const auto clamped = [](const Vec2& P) { return P.x() == 0 || P.x() == 1; };
    const MatX free = testing::free_motions(cloth, make_dof_map(cloth), clamped);
    ASSERT_TRUE(testing::settle(cloth, material, free, 0.05, 1e-9, 2000));
    double lowest = 0;
    for (const Vec3& x : cloth.mesh.x) lowest = std::min(lowest, x.z());
    EXPECT_NEAR(-lowest, catenary_sag(span, E, material.density * g), 1e-4);
  }
}

// Heavy elastica (strip clamped level, Gamma = rho g L^3/D): drop of the tip over L, by shooting to 1e-11. Here every
// column of vertices moves as one, as in a wide sheet, and the mesh with one diagonal is then exactly the plate D = B.
// Left free, a narrow strip of it also twists and sinks further: the bend-twist coupling of that mesh family.
TEST(Cantilever, DropsLikeTheHeavyElastica) {
  constexpr int n = 40;
  // A hinge stands for the curvature from half an element before it to half an element behind it. The first one that
  // bends is on the second held column, so the strip of length 1 begins half an element before that.
  constexpr double l = 1 / (n + 0.5);
  for (const auto& [gamma, drop] : {std::pair{0.1, 0.01249844}, {1.0, 0.12347140}, {10.0, 0.70019972}}) {
    SCOPED_TRACE("Gamma " + std::to_string(gamma));
    const Material material{.density = 0.1, .youngs = 1e4, .poisson = 0, .bending = 0.1 * g / gamma};
    Cloth cloth = make_cloth(make_grid({.size = {(n + 1) * l, l}, .cells = {n + 1, 1}, .pattern = GridPattern::Right}));
    const DofMap dofs = make_dof_map(cloth);
    MatX columns_together = MatX::Zero(dofs.size(), 2 * n);
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      const int column = v % (n + 2) - 2;
      if (column < 0) continue;
      columns_together(dofs.x(v), 2 * column) = 1;
      columns_together(dofs.x(v) + 2, 2 * column + 1) = 1;
    }
    ASSERT_TRUE(testing::settle(cloth, material, columns_together, 0.1, 1e-9, 3000));
    EXPECT_NEAR(-cloth.mesh.x.back().z(), drop, 1e-3 * drop);  // (l/L)^2 ~ 6e-4 of discretisation
  }
}

// What is left of the mesh when nothing is held together: a free strip also bends across and twists, and each family
// resists that differently (right 0.83, alternating 0.84, cross 1.12, irregular 0.87 of B on a finer, longer-running
// mesh). Nothing is tuned to this; the bounds say how far `bending` may be from what a cantilever shows.
TEST(Cantilever, ShowsTheGivenStiffnessWithinAQuarterOnEveryGrid) {
  constexpr int n = 12;
  constexpr double l = 1 / (n + 0.5);
  const double gamma = 0.1, drop = 0.01249844;  // nearly linear: drop ~ 1/B
  const Material material{.density = 0.1, .youngs = 1e4, .poisson = 0, .bending = 0.1 * g / gamma};
  for (const GridPattern pattern :
       {GridPattern::Right, GridPattern::Alternating, GridPattern::Cross, GridPattern::Irregular}) {
    SCOPED_TRACE("pattern " + std::to_string(static_cast<int>(pattern)));
    Cloth cloth = make_cloth(make_grid({.size = {(n + 1) * l, 3 * l}, .cells = {n + 1, 3}, .pattern = pattern}));
    const auto held = [](const Vec2& P) { return P.x() < 1.25 * l; };
    const MatX free = testing::free_motions(cloth, make_dof_map(cloth), held);
    ASSERT_TRUE(testing::settle(cloth, material, free, 0.1, 1e-9, 400));
    double tip = 0;
    int count = 0;
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      if (cloth.mesh.X[v].x() < (n + 0.99) * l) continue;
      tip += cloth.mesh.x[v].z();
      ++count;
    }
    EXPECT_NEAR(drop / (-tip / count), 1.0, 0.25);
  }
}

}  // namespace
}  // namespace crease
