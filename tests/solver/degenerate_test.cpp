// SPDX-License-Identifier: MIT
// Problems without a solution, with many, and with numbers at the edge of the representable.
#include <gtest/gtest.h>

#include <cmath>

#include "crease/solver/qp_solver.hpp"
#include "support/qp_problems.hpp"

namespace crease {
namespace {

using support::dense_problem;
using support::Random;
using support::RowBuilder;

QpResult solve(const QpProblem& problem, const QpOptions& options = {}) {
  return make_qp_solver(QpMethod::ActiveSet)->solve(problem, options);
}

/// Cloth with contacts and one pair of rows that exclude each other, added by `spoil(eq, in, start of a vertex)`.
template <class Spoil>
QpProblem spoiled_cloth(std::uint64_t seed, Spoil spoil) {
  Random random(seed);
  QpProblem problem = support::cloth_like(random, {.side = 6, .eulerian = false});
  RowBuilder eq(problem.f.size()), in(problem.f.size());
  for (int v = 0; v < 36; v += 2) in.add(problem.blocks[v], random.vector(3).normalized(), random.uniform(-1, 0));
  spoil(eq, in, problem.blocks);
  eq.finish(problem.A_eq, problem.b_eq);
  in.finish(problem.A_in, problem.b_in);
  return problem;
}

void expect_infeasible(const QpProblem& problem) {
  const QpResult result = solve(problem);
  EXPECT_EQ(result.status, QpStatus::Infeasible) << result.message;
  EXPECT_EQ(result.q.size(), 0);
}

TEST(InfeasibleQp, IsReportedForAVertexBetweenTwoWallsThatOverlap) {
  for (const double overlap : {1.0, 1e-3}) {
    SCOPED_TRACE(overlap);
    expect_infeasible(spoiled_cloth(1, [&](RowBuilder&, RowBuilder& in, const std::vector<int>& blocks) {
      const Vec3 normal = Vec3(1, 2, 2) / 3;
      in.add(blocks[3], normal, 0.5);
      in.add(blocks[3], -normal, overlap - 0.5);
    }));
  }
}

TEST(InfeasibleQp, IsReportedForAPinInsideAWall) {
  expect_infeasible(spoiled_cloth(2, [](RowBuilder& eq, RowBuilder& in, const std::vector<int>& blocks) {
    for (int k = 0; k < 3; ++k) eq.add(blocks[5], VecX::Unit(3, k), 0.0);
    in.add(blocks[5], Vec3(0, 0.6, 0.8), 0.1);
  }));
}

TEST(InfeasibleQp, IsReportedForContradictingEqualitiesOfOneVertex) {
  expect_infeasible(spoiled_cloth(3, [](RowBuilder& eq, RowBuilder&, const std::vector<int>& blocks) {
    eq.add(blocks[5], Vec3(1, 1, 0), 1.0);
    eq.add(blocks[5], Vec3(2, 2, 0), 1.0);
  }));
}

TEST(InfeasibleQp, IsReportedForRowsOverSeveralVertices) {
  expect_infeasible(spoiled_cloth(4, [](RowBuilder&, RowBuilder& in, const std::vector<int>& blocks) {
    in.add({{blocks[1], Vec3(1, 0, 0)}, {blocks[7], Vec3(-1, 0, 0)}}, 1.0);
    in.add({{blocks[7], Vec3(1, 0, 0)}, {blocks[20], Vec3(-1, 0, 0)}}, 1.0);
    in.add({{blocks[20], Vec3(1, 0, 0)}, {blocks[1], Vec3(-1, 0, 0)}}, -1.9);
  }));
  expect_infeasible(spoiled_cloth(4, [](RowBuilder& eq, RowBuilder&, const std::vector<int>& blocks) {
    eq.add({{blocks[1], Vec3(1, 0, 0)}, {blocks[7], Vec3(-1, 0, 0)}}, 1.0);
    eq.add({{blocks[1], Vec3(1, 0, 0)}, {blocks[7], Vec3(-1, 0, 0)}}, 2.0);
  }));
  // Decided by pins on all it touches.
  expect_infeasible(spoiled_cloth(4, [](RowBuilder& eq, RowBuilder& in, const std::vector<int>& blocks) {
    for (const int v : {1, 7})
      for (int k = 0; k < 3; ++k) eq.add(blocks[v], VecX::Unit(3, k), 0.0);
    in.add({{blocks[1], Vec3(1, 0, 0)}, {blocks[7], Vec3(-1, 0, 0)}}, 1.0);
  }));
}

TEST(InfeasibleQp, IsReportedForARowOfZeros) {
  QpProblem problem =
      dense_problem(MatX::Identity(2, 2), VecX::Ones(2), MatX(), VecX(), MatX::Zero(1, 2), VecX::Ones(1));
  expect_infeasible(problem);
  problem.b_in[0] = -1;
  EXPECT_EQ(solve(problem).status, QpStatus::Solved);
}

TEST(FeasibleQp, IsSolvedWhereWallsTouchThePinOrEachOther) {
  const QpResult result = solve(spoiled_cloth(5, [](RowBuilder& eq, RowBuilder& in, const std::vector<int>& blocks) {
    const Vec3 normal = Vec3(1, 2, 2) / 3;
    in.add(blocks[3], normal, 0.3);
    in.add(blocks[3], -normal, -0.3);
    for (int k = 0; k < 3; ++k) eq.add(blocks[8], VecX::Unit(3, k), 0.2);
    in.add(blocks[8], normal, normal.sum() * 0.2);
    eq.add({{blocks[1], normal}, {blocks[7], -normal}}, 0.0);
    in.add({{blocks[1], normal}, {blocks[7], -normal}}, 0.0);
  }));
  ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
  EXPECT_LE(result.kkt_residual, 1e-9);
}

/// Springs between neighbours in a ring: rigid motion costs nothing.
MatX ring(int n) {
  MatX H = MatX::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    H(i, i) += 1, H(j, j) += 1, H(i, j) -= 1, H(j, i) -= 1;
  }
  return H;
}

TEST(SingularQp, IsUnboundedIfAForceActsAlongTheFreeDirection) {
  const int n = 10;
  const VecX f = VecX::Constant(n, 0.1) + VecX::Unit(n, 3);
  const QpProblem problem = dense_problem(ring(n), f, MatX(), VecX(), MatX(), VecX());
  EXPECT_EQ(solve(problem).status, QpStatus::Unbounded);
  // A wall on the far side does not help, one in the way does.
  const QpProblem behind =
      dense_problem(ring(n), f, MatX(), VecX(), VecX::Unit(n, 2).transpose(), VecX::Constant(1, -1));
  EXPECT_EQ(solve(behind).status, QpStatus::Unbounded);
  const QpProblem ahead =
      dense_problem(ring(n), f, MatX(), VecX(), -VecX::Unit(n, 2).transpose(), VecX::Constant(1, -1));
  const QpResult stopped = solve(ahead);
  ASSERT_EQ(stopped.status, QpStatus::Solved) << stopped.message;
  EXPECT_LE(stopped.kkt_residual, 1e-9);
  EXPECT_NEAR(stopped.q[2], 1, 1e-9);
  EXPECT_NEAR(stopped.lambda_in[0], f.sum(), 1e-8);  // the wall carries all of it
}

TEST(SingularQp, IsSolvedIfNothingActsAlongTheFreeDirection) {
  const int n = 10;
  const VecX f = VecX::Unit(n, 3) - VecX::Unit(n, 7);
  const QpResult result = solve(dense_problem(ring(n), f, MatX(), VecX(), MatX(), VecX()));
  ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
  EXPECT_LE((ring(n) * result.q - f).norm(), 1e-9);
  EXPECT_LE(result.q.norm(), 10) << "drifts along the free direction";
}

TEST(SingularQp, IsSolvedWhereAnEqualityOverSeveralUnknownsPinsIt) {
  const int n = 10;
  const QpProblem problem =
      dense_problem(ring(n), VecX::Constant(n, 0.1), MatX::Ones(1, n), VecX::Constant(1, 5), MatX(), VecX());
  const QpResult result = solve(problem);
  ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
  EXPECT_LE((result.q - VecX::Constant(n, 0.5)).norm(), 1e-9);
}

TEST(SingularQp, IsSolvedForAFlatSheetFromAnyStart) {
  // One vertex on the edge of a flat sheet, tied to nothing: world motion x and material motion X along the sheet are
  // one and the same motion, M = m B^T B with B = [I -F]; contact n, the tangent rule t . X = 0, and the small weight
  // on the normal that constraints add leave a unique answer.
  const Mat32 F = (Mat32() << 1, 0, 0, 1, 0, 0).finished();
  Eigen::Matrix<double, 3, 5> B;
  B << Mat3::Identity(), -F;
  MatX H = 1e-5 * B.transpose() * B;
  H.topLeftCorner(3, 3) += 1e-6 * 1e-5 * Vec3(1, 0, 0) * Vec3(1, 0, 0).transpose();
  const VecX f = 1e-5 * B.transpose() * Vec3(0.3, 0.1, -1);
  const MatX A_eq = VecX::Unit(5, 4).transpose();
  MatX A_in = MatX::Zero(2, 5);
  A_in(0, 2) = 1;
  A_in(1, 0) = 1;
  QpProblem problem = dense_problem(H, f, A_eq, VecX::Zero(1), A_in, VecX::Zero(2));
  problem.blocks = {0, 5};
  for (const std::vector<char>& guess : {std::vector<char>{1, 1}, {0, 0}, {0, 1}, {1, 0}}) {
    const QpResult result = make_qp_solver(QpMethod::ActiveSet)->solve(problem, {}, guess);
    ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
    // Stays on the edge, the whole motion shows as material sliding under it: X = -x.
    EXPECT_NEAR(result.q[0], 0, 1e-9);
    EXPECT_NEAR(result.q[3], -0.3, 1e-9);
    EXPECT_NEAR(result.lambda_in[0], 1e-5, 1e-13);
  }
}

/// Two equal rows across blocks, first met with q0 held at its bound, where they are stiff; free of it they give way
/// 2e8 times as far. A softness made for the first is then less than rounding, and the border that holds both is
/// singular.
TEST(DependentRows, StaySolvableWhenLettingGoMakesThemCompliant) {
  const double decoupled = 1e-8;
  const MatX H = (MatX(2, 2) << 1, 1 - decoupled, 1 - decoupled, 1).finished();
  const MatX A_in = (MatX(3, 2) << 1, 0, 1, -1, 1, -1).finished();
  const QpProblem problem =
      dense_problem(H, VecX::Constant(2, 2), MatX(), VecX(), A_in, (VecX(3) << 0, 1, 1).finished());
  const QpResult result = make_qp_solver(QpMethod::ActiveSet)->solve(problem, {}, std::vector<char>{1, 1, 1});
  ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
  EXPECT_FALSE(result.fell_back);
  // q0 - q1 = 1 and, along (1, 1), (2 - decoupled) (q0 + q1) = 4.
  EXPECT_NEAR(result.q[0], 2 / (2 - decoupled) + 0.5, 1e-8);
  EXPECT_NEAR(result.q[1], 2 / (2 - decoupled) - 0.5, 1e-8);
}

// Two rows across two blocks that leave a wedge, which the force closes: q = 0, held by multipliers of 1/angle. Below
// an angle of 3e-6 the softness of the rows is more than what the wedge yields.
TEST(DependentRows, HoldTheEndOfAWedge) {
  const QpOptions options;
  for (const double angle : {1e-4, 1e-5, 1e-6, 1e-7}) {
    SCOPED_TRACE(angle);
    MatX A(2, 6);
    A << 1, 0, 0, -1, 0, 0, -1, angle, 0, 1, angle, 0;
    VecX f = VecX::Zero(6);
    f[1] = f[4] = -1;
    QpProblem problem = dense_problem(MatX::Identity(6, 6), f, MatX(), VecX(), A, VecX::Zero(2));
    problem.blocks = {0, 3, 6};
    const QpResult result = solve(problem, options);
    ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
    EXPECT_FALSE(result.fell_back);
    // A row may miss zero by the tolerance, and q its end by that over the angle.
    const double allowed = 4 * options.tolerance / angle;
    EXPECT_LT(result.q.norm(), allowed);
    for (int row = 0; row < 2; ++row) EXPECT_NEAR(result.lambda_in[row] * angle, 1, allowed);
  }
}

TEST(IndefiniteQp, IsReported) {
  MatX H = MatX::Identity(4, 4);
  H(2, 2) = -1;
  const QpResult result = solve(dense_problem(H, VecX::Ones(4), MatX(), VecX(), MatX(), VecX()));
  EXPECT_NE(result.status, QpStatus::Solved);
  EXPECT_EQ(result.q.size(), 0);
  EXPECT_FALSE(result.message.empty());
}

TEST(QpBudget, SpentByTheActiveSetLeavesTheAnswerToTheReference) {
  Random random(9);
  QpProblem problem = support::cloth_like(random, {.side = 8});
  support::add_contacts(random, {.share = 0.8}, problem);
  const QpResult plain = solve(problem), result = solve(problem, {.max_iterations = 1});
  ASSERT_EQ(plain.status, QpStatus::Solved);
  EXPECT_FALSE(plain.fell_back);
  ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
  EXPECT_TRUE(result.fell_back);
  EXPECT_LE(result.kkt_residual, 1e-8);
  EXPECT_LE((result.q - plain.q).norm(), 1e-6 * plain.q.norm());  // 1e-8 of the forces, times the condition of H
}

TEST(QpBudget, EndsTheSearchWithTheBestPointSoFar) {
  Random random(9);
  QpProblem problem = support::cloth_like(random, {.side = 12});
  support::add_contacts(random, {.share = 0.8, .degenerate = true, .edge_edge = 20}, problem);
  const QpResult result = make_qp_solver(QpMethod::Ipopt)->solve(problem, {.max_iterations = 1});
  EXPECT_EQ(result.status, QpStatus::IterationLimit);
  EXPECT_EQ(result.iterations, 1);
  ASSERT_EQ(result.q.size(), problem.f.size());
  EXPECT_TRUE(result.q.allFinite());
  EXPECT_FALSE(result.message.empty());
}

TEST(ScaledQp, DoesNotDependOnUnits) {
  Random random(10);
  QpProblem problem = support::cloth_like(random, {.side = 6});
  support::add_contacts(random, {.share = 0.6, .degenerate = true, .edge_edge = 5}, problem);
  const QpResult plain = solve(problem);
  ASSERT_EQ(plain.status, QpStatus::Solved);
  for (const double mass : {0x1p-60, 0x1p60})
    for (const double speed : {0x1p-60, 0x1p60}) {
      SCOPED_TRACE(mass * speed);
      QpProblem scaled = problem;
      scaled.H *= mass;
      scaled.f *= mass * speed;
      scaled.b_eq *= speed;
      scaled.b_in *= speed;
      const QpResult result = solve(scaled);
      ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
      EXPECT_LE((result.q / speed - plain.q).norm(), 1e-7 * plain.q.norm());
    }
}

TEST(ScaledQp, RestsAtZero) {
  // Nothing moves, nothing pulls: relative tolerances have no scale to hold on to.
  Random random(11);
  QpProblem problem = support::cloth_like(random, {.side = 5});
  support::add_contacts(random, {.share = 0.6, .edge_edge = 3}, problem);
  problem.f.setZero();
  problem.b_eq.setZero();
  problem.b_in.setZero();
  for (const QpMethod method : {QpMethod::ActiveSet, QpMethod::InteriorPoint, QpMethod::Ipopt}) {
    const QpResult result = make_qp_solver(method)->solve(problem);
    ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
    EXPECT_EQ(result.q.norm(), 0);
  }
}

}  // namespace
}  // namespace crease
