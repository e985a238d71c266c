// SPDX-License-Identifier: MIT
#include "crease/dynamics/inertia.hpp"

#include <string>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "crease/geometry/triangle.hpp"
#include "support/element_cases.hpp"

namespace crease {
namespace {

using testing::Rng;

constexpr double rho = 0.37;

// Positions and velocities as 15-vectors in the order of Eq. 4.
struct Pose15 {
  std::array<Vec2, 3> X;
  std::array<Vec3, 3> x;
};
Vec15 pack(const std::array<Vec3, 3>& x, const std::array<Vec2, 3>& X) {
  Vec15 q;
  q << x[0], x[1], x[2], X[0], X[1], X[2];
  return q;
}
Pose15 unpack(const Vec15& q) {
  Pose15 pose;
  for (int i = 0; i < 3; ++i) {
    pose.x[i] = q.segment<3>(3 * i);
    pose.X[i] = q.segment<2>(9 + 2 * i);
  }
  return pose;
}
Mat15 inertia_at(const Vec15& q) {
  const Pose15 pose = unpack(q);
  return eol_inertia(pose.X, pose.x, rho);
}

TriangleState random_state(Rng& rng) {
  TriangleState state;
  state.X = testing::random_material_triangle(rng);
  state.x = testing::random_world_triangle(state.X, 0.4, rng);
  for (int i = 0; i < 3; ++i) {
    state.V[i] = rng.vec2(0.5);
    state.v[i] = rng.vec3();
  }
  return state;
}

Vec15 velocity(const TriangleState& state) {
  return pack(state.v, state.V);
}

template <typename Test>
void for_random_states(const Test& test) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    test(random_state(rng), rng);
  }
}

TEST(EolJacobian, IsTheDerivativeOfAMaterialPointThatStaysWhereItIs) {
  for_random_states([](const TriangleState& state, Rng&) {
    const Vec3 alpha(0.25, 0.35, 0.4);
    const Vec2 P = alpha[0] * state.X[0] + alpha[1] * state.X[1] + alpha[2] * state.X[2];
    const Vec15 q = pack(state.x, state.X);
    const auto J = eol_jacobian(state.X, state.x, alpha);
    for (int k = 0; k < 15; ++k) {
      const auto point = [&](double step) {
        const Pose15 pose = unpack(q + step * Vec15::Unit(k));
        const Vec3 b = barycentric(pose.X, P);
        return Vec3(b[0] * pose.x[0] + b[1] * pose.x[1] + b[2] * pose.x[2]);
      };
      EXPECT_LT((J.col(k) - testing::central_difference(point, 1e-3)).norm(), 1e-9) << "dof " << k;
    }
  });
}

// Dunavant's six-point rule of degree 4 for the integrand rho J^T J of degree 2.
TEST(EolInertia, IsTheIntegralOfTheJacobians) {
  for_random_states([](const TriangleState& state, Rng&) {
    const double near[2] = {0.445948490915965, 0.091576213509771};
    const double weight[2] = {0.223381589678011, 0.109951743655322};
    const Vec2 b = state.X[1] - state.X[0], c = state.X[2] - state.X[0];
    const double area = 0.5 * (b.x() * c.y() - b.y() * c.x());
    Mat15 M = Mat15::Zero();
    for (int orbit = 0; orbit < 2; ++orbit) {
      for (int k = 0; k < 3; ++k) {
        Vec3 alpha = Vec3::Constant(near[orbit]);
        alpha[k] = 1 - 2 * near[orbit];
        const auto J = eol_jacobian(state.X, state.x, alpha);
        M += weight[orbit] * area * rho * J.transpose() * J;
      }
    }
    const Mat15 closed = eol_inertia(state.X, state.x, rho);
    EXPECT_LT((closed - M).norm(), 1e-13 * M.norm());  // the rule's constants have 15 digits
    EXPECT_EQ(closed, closed.transpose());
  });
}

TEST(EolInertia, HasRankNine) {
  for_random_states([](const TriangleState& state, Rng&) {
    const Eigen::SelfAdjointEigenSolver<MatX> eigen(eol_inertia(state.X, state.x, rho), Eigen::EigenvaluesOnly);
    const VecX values = eigen.eigenvalues();
    EXPECT_EQ((values.array() > 1e-12 * values[14]).count(), 9);  // six motions (F c_i, c_i), one pair a vertex
    EXPECT_GE(values[0], -1e-14 * values[14]);
  });
}

// C = Mdot qdot - 1/2 d(qdot^T M qdot)/dq with M from Eq. 8 and fourth-order differences.
TEST(EolVelocityTerms, AreTheDerivativesOfTheInertia) {
  for_random_states([](const TriangleState& state, Rng&) {
    const Vec15 q = pack(state.x, state.X), q_dot = velocity(state);
    const auto along_motion = [&](double step) { return inertia_at(q + step * q_dot); };
    Vec15 C = testing::central_difference(along_motion, 1e-3) * q_dot;
    for (int k = 0; k < 15; ++k) {
      const auto kinetic = [&](double step) { return 0.5 * q_dot.dot(inertia_at(q + step * Vec15::Unit(k)) * q_dot); };
      C[k] -= testing::central_difference(kinetic, 1e-3);
    }
    // Truncation ~ (1e-3/size)^4 = 1e-12 with a factor of hundreds from fifth derivatives of 1/area.
    EXPECT_LT((eol_velocity_terms(state, rho) - C).norm(), 1e-9 * C.norm());
  });
}

TEST(EolVelocityTerms, DoTheWorkOfTheChangingInertia) {
  for_random_states([](const TriangleState& state, Rng&) {
    const Vec15 q = pack(state.x, state.X), q_dot = velocity(state);
    const auto along_motion = [&](double step) { return q_dot.dot(inertia_at(q + step * q_dot) * q_dot); };
    const double expected = 0.5 * testing::central_difference(along_motion, 1e-3);
    EXPECT_NEAR(q_dot.dot(eol_velocity_terms(state, rho)), expected, 1e-9);
  });
}

TEST(EolVelocityTerms, LeaveLagrangianMotionAlone) {
  for_random_states([](TriangleState state, Rng&) {
    state.V.fill(Vec2::Zero());
    EXPECT_EQ(eol_velocity_terms(state, rho).head<9>().norm(), 0);
  });
}

// xdot_i = F c, Xdot_i = c renames material points and moves nothing.
TEST(EolVelocityTerms, VanishForRelabelling) {
  for_random_states([](TriangleState state, Rng& rng) {
    const Vec2 c = rng.vec2();
    state.V.fill(c);
    state.v.fill(deformation_gradient(state.X, state.x) * c);
    EXPECT_LT(eol_velocity_terms(state, rho).norm(), 1e-15);
    EXPECT_LT((eol_inertia(state.X, state.x, rho) * velocity(state)).norm(), 1e-15);
  });
}

}  // namespace
}  // namespace crease
