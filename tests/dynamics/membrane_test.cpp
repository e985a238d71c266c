// SPDX-License-Identifier: MIT
#include "crease/dynamics/membrane.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "support/element_cases.hpp"

namespace crease {
namespace {

using testing::Rng;

// F is (x_b - x_a, x_c - x_a) on this triangle, and (x_b, x_c) are the six numbers of F.
const std::array<Vec2, 3> unit_triangle{Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)};
constexpr double unit_area = 0.5;

const Material cloth{.density = 0.05, .youngs = 1000, .poisson = 0.3, .bending = 0, .damping = 0};

std::array<Vec3, 3> shifted(std::array<Vec3, 3> x, int dof, double step) {
  x[dof / 3][dof % 3] += step;
  return x;
}

std::array<Vec3, 3> world(const Mat32& F) {
  return {Vec3::Zero(), F.col(0), F.col(1)};
}

// First Piola stress from the nodal forces f_i = -A P g_i on the unit triangle, g_b = e_1, g_c = e_2.
Mat32 stress(const Mat32& F, const Material& material) {
  const MembraneElement element = membrane_element(unit_triangle, world(F), material);
  Mat32 P;
  P << -element.force.segment<3>(3) / unit_area, -element.force.segment<3>(6) / unit_area;
  return P;
}

TEST(Membrane, ForceIsMinusEnergyGradient) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const auto X = testing::random_material_triangle(rng);
    const auto x = testing::random_world_triangle(X, 0.4, rng);
    const Vec9 force = membrane_element(X, x, cloth).force;
    for (int k = 0; k < 9; ++k) {
      const auto energy = [&](double step) { return membrane_element(X, shifted(x, k, step), cloth).energy; };
      // Energies ~ 1e2 J carry 1e-14 of rounding: 1e-14/1e-3 = 1e-11 from it, 1e-12 from truncation.
      EXPECT_NEAR(force[k], -testing::central_difference(energy, 1e-3), 1e-8 * (1 + force.norm())) << "dof " << k;
    }
  }
}

TEST(Membrane, StiffnessIsMinusForceGradientUnderTension) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const auto X = testing::random_material_triangle(rng);
    const Mat3 Q = rng.rotation();
    Mat32 F = Q.leftCols<2>();
    F.col(0) *= rng.uniform(1.05, 1.6);  // both principal stresses are tensile: no eigenvalue is negative
    F.col(1) *= rng.uniform(1.05, 1.6);
    const std::array<Vec3, 3> x{F * X[0], F * X[1], F * X[2]};
    const Mat9 stiffness = membrane_element(X, x, cloth).stiffness;
    for (int k = 0; k < 9; ++k) {
      const auto force = [&](double step) { return membrane_element(X, shifted(x, k, step), cloth).force; };
      const Vec9 column = -testing::central_difference(force, 1e-3);
      EXPECT_LT((stiffness.col(k) - column).norm(), 1e-8 * stiffness.norm()) << "dof " << k;
    }
  }
}

// The closed-form modes against a numerical eigenvalue decomposition of the finite-difference Hessian.
TEST(Membrane, StiffnessIsHessianWithNegativeEigenvaluesSetToZero) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    Mat32 F;
    for (int k = 0; k < 6; ++k) F(k % 3, k / 3) = rng.uniform(-1.5, 1.5);  // tension, compression and both
    const auto x = world(F);
    MatX hessian(6, 6);
    for (int k = 0; k < 6; ++k) {
      const auto force = [&](double step) {
        return Vec9(membrane_element(unit_triangle, shifted(x, 3 + k, step), cloth).force);
      };
      hessian.col(k) = -testing::central_difference(force, 1e-4).tail<6>();
    }
    const Eigen::SelfAdjointEigenSolver<MatX> eigen(0.5 * (hessian + hessian.transpose()));
    const MatX projected =
        eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
    const Mat9 stiffness = membrane_element(unit_triangle, x, cloth).stiffness;
    // A stretch of .05 curves psi over .05, hence a truncation error (1e-4/.05)^4 ~ 1e-11 beside 1e-11 of rounding.
    EXPECT_LT((stiffness.block<6, 6>(3, 3) - projected).norm(), 1e-7 * projected.norm());
  }
}

void expect_finite_and_psd(const std::array<Vec3, 3>& x) {
  const MembraneElement element = membrane_element(unit_triangle, x, cloth);
  EXPECT_TRUE(std::isfinite(element.energy));
  EXPECT_TRUE(element.force.allFinite());
  ASSERT_TRUE(element.stiffness.allFinite());
  EXPECT_EQ(element.stiffness, element.stiffness.transpose());
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(element.stiffness, Eigen::EigenvaluesOnly);
  EXPECT_GE(eigen.eigenvalues()[0], -1e-13 * eigen.eigenvalues()[8]);  // rounding of 9 x 9 products
}

TEST(Membrane, StaysFiniteAndSemidefiniteOnDegenerateTriangles) {
  const Vec3 e = Vec3(1, 2, -1).normalized(), n = Vec3(2, -1, 0).normalized();
  for (const double s1 : {0.0, 1e-300, 1e-14, 1e-8, 1e-3, 0.5, 1.0, 3.0, 10.0, 1e4}) {
    for (const double s2 : {0.0, 1e-300, 1e-14, 1e-8, 1e-3, 0.5, 1.0, 3.0, 10.0}) {
      SCOPED_TRACE("stretches " + std::to_string(s1) + ", " + std::to_string(s2));
      Mat32 F;
      F << s1 * e, s2 * n;
      expect_finite_and_psd(world(F));
      F << s1 * e + s2 * n, s1 * e - s2 * n;
      expect_finite_and_psd(world(F));
    }
  }
}

TEST(Membrane, FollowsRigidMotions) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const auto X = testing::random_material_triangle(rng);
    const auto x = testing::random_world_triangle(X, 0.3, rng);
    const Mat3 Q = rng.rotation();
    const Vec3 offset = rng.vec3(10);
    const std::array<Vec3, 3> moved{Q * x[0] + offset, Q * x[1] + offset, Q * x[2] + offset};
    const MembraneElement before = membrane_element(X, x, cloth), after = membrane_element(X, moved, cloth);
    EXPECT_NEAR(after.energy, before.energy, 1e-12 * before.energy);
    Vec3 total = Vec3::Zero(), torque = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      const Vec3 f = before.force.segment<3>(3 * i);
      EXPECT_LT((after.force.segment<3>(3 * i) - Q * f).norm(), 1e-12 * cloth.youngs);
      total += f;
      torque += x[i].cross(f);
    }
    EXPECT_LT(total.norm(), 1e-13 * cloth.youngs);
    EXPECT_LT(torque.norm(), 1e-13 * cloth.youngs);
    for (int axis = 0; axis < 3; ++axis) {
      Vec9 translation = Vec9::Zero();
      for (int i = 0; i < 3; ++i) translation[3 * i + axis] = 1;
      EXPECT_LT((before.stiffness * translation).norm(), 1e-12 * before.stiffness.norm());
    }
    const std::array<Vec3, 3> rigid{Q.leftCols<2>() * X[0] + offset, Q.leftCols<2>() * X[1] + offset,
                                    Q.leftCols<2>() * X[2] + offset};
    // F of a triangle of size 1 that lies 10 m away is known to 1e-15 only.
    EXPECT_LT(membrane_element(X, rigid, cloth).force.norm(), 1e-13 * cloth.youngs);
  }
}

// First Piola stresses of the corotated linear sheet in plane stress, in closed form: mu |S - I|^2 +
// lambda/2 tr(S - I)^2 differentiated by hand for each patch.
TEST(Membrane, ShowsTheStressesOfPlaneStressElasticity) {
  const double E = cloth.youngs, nu = cloth.poisson;
  const double mu = E / (2 * (1 + nu)), lambda = E * nu / (1 - nu * nu);
  const Mat32 Q = Rng(7).rotation().leftCols<2>();
  const double tolerance = 1e-12 * E;
  for (const double l : {0.9, 1.0, 1.05, 1.2, 1.5}) {
    SCOPED_TRACE("stretch " + std::to_string(l));
    const Mat2 uniaxial = Vec2(l, 1 - nu * (l - 1)).asDiagonal();
    const Mat2 uniaxial_stress = Vec2(E * (l - 1), 0).asDiagonal();
    EXPECT_LT((stress(Q * uniaxial, cloth) - Q * uniaxial_stress).norm(), tolerance);

    EXPECT_LT((stress(l * Q, cloth) - E / (1 - nu) * (l - 1) * Q).norm(), tolerance);

    const double trace = l + 1 / l - 2;
    const Mat2 shear = Vec2(l, 1 / l).asDiagonal();
    const Mat2 shear_stress =
        Vec2(2 * mu * (l - 1) + lambda * trace, 2 * mu * (1 / l - 1) + lambda * trace).asDiagonal();
    EXPECT_LT((stress(Q * shear, cloth) - Q * shear_stress).norm(), tolerance);
  }
  for (const double gamma : {0.1, 0.5, 1.0}) {
    SCOPED_TRACE("simple shear " + std::to_string(gamma));
    const double q = std::sqrt(4 + gamma * gamma);  // tr S
    Mat2 F2, R;
    F2 << 1, gamma, 0, 1;
    R << 2 / q, gamma / q, -gamma / q, 2 / q;
    const Mat2 S = R.transpose() * F2;
    const Mat2 P = R * (2 * mu * (S - Mat2::Identity()) + lambda * (q - 2) * Mat2::Identity());
    EXPECT_LT((stress(Q * F2, cloth) - Q * P).norm(), tolerance);
  }
}

}  // namespace
}  // namespace crease
