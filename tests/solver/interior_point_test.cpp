// SPDX-License-Identifier: MIT
// Our own interior point against the active set, which shares nothing with it but the KKT residual.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "crease/solver/qp_solver.hpp"
#include "support/qp_problems.hpp"

namespace crease {
namespace {

using support::objective;
using support::Random;

QpResult solve(QpMethod method, const QpProblem& problem, const QpOptions& options = {}) {
  return make_qp_solver(method)->solve(problem, options);
}

// Both are optimal to 1e-8 of the forces: objectives, which are flat there, agree much better than q.
void expect_same_optimum(const QpProblem& problem) {
  const QpResult ours = solve(QpMethod::InteriorPoint, problem), theirs = solve(QpMethod::ActiveSet, problem);
  ASSERT_EQ(theirs.status, QpStatus::Solved) << theirs.message;
  ASSERT_FALSE(theirs.fell_back);
  ASSERT_EQ(ours.status, QpStatus::Solved) << ours.message;
  EXPECT_LE(kkt_residual(problem, ours.q, ours.lambda_eq, ours.lambda_in), 1e-8);
  const double value = objective(problem, theirs.q);
  EXPECT_NEAR(objective(problem, ours.q), value, 1e-8 * std::abs(value));
  EXPECT_LE(ours.iterations, 60);
}

TEST(InteriorPoint, AgreesWithTheActiveSetOnRandomProblems) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const int n = random.integer(2, 12);
    expect_same_optimum(support::random_dense(random, n, random.integer(0, n / 2), random.integer(0, 15)));
  }
}

// Repeated, opposite, parallel and surplus normals, dependent rows over several vertices; rags and metal sheets.
TEST(InteriorPoint, AgreesWithTheActiveSetOnCloth) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    support::ClothLike cloth{.side = random.integer(2, 8)};
    cloth.mass = std::pow(10, random.uniform(-6, -3));
    cloth.stiffness = cloth.mass * std::pow(10, random.uniform(-2, 6));
    QpProblem problem = support::cloth_like(random, cloth);
    support::add_contacts(random,
                          {.share = random.uniform(0, 1),
                           .pinned = 0.1,
                           .degenerate = seed % 2 == 1,
                           .edge_edge = random.integer(0, 30),
                           .general_eq = random.integer(0, 4)},
                          problem);
    expect_same_optimum(problem);
  }
}

// min q_1^2 / 2 + q_1 - q_2 / 2 with q_2 <= 3 and q_1 >= q_2 - 3: nothing but a bound holds q_2, where H has no entry.
TEST(InteriorPoint, SolvesASingularProblemThatBoundsHold) {
  MatX H = MatX::Zero(2, 2), A(2, 2);
  H(0, 0) = 1;
  A << 0, -1, 1, -1;
  const QpProblem problem =
      support::dense_problem(H, Eigen::Vector2d(-1, 0.5), MatX(), VecX(), A, Eigen::Vector2d(-3, -3));
  const QpResult result = solve(QpMethod::InteriorPoint, problem);
  ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
  // On the second row q_2 = q_1 + 3: q_1^2 / 2 + q_1 / 2 - 3 / 2 is least at q_1 = -1/2.
  EXPECT_NEAR(result.q[0], -0.5, 1e-9);
  EXPECT_NEAR(result.q[1], 2.5, 1e-9);
  EXPECT_NEAR(result.lambda_in[1], 0.5, 1e-9);
}

TEST(InteriorPoint, EndsWhereThereIsNoSolution) {
  // q >= 1 and q <= -1; and a force where nothing holds.
  const QpProblem none = support::dense_problem(MatX::Identity(1, 1), VecX::Zero(1), MatX(), VecX(),
                                                Eigen::Vector2d(1, -1), Eigen::Vector2d(1, 1));
  const QpProblem endless =
      support::dense_problem(MatX::Zero(1, 1), VecX::Ones(1), MatX(), VecX(), MatX::Ones(1, 1), VecX::Zero(1));
  for (const QpProblem* problem : {&none, &endless}) {
    const QpResult result = solve(QpMethod::InteriorPoint, *problem);
    EXPECT_EQ(result.status, QpStatus::NumericalTrouble);
    EXPECT_EQ(result.q.size(), 0);
    EXPECT_FALSE(result.message.empty());
  }
}

TEST(InteriorPoint, EndsWithItsBudget) {
  Random random(9);
  QpProblem problem = support::cloth_like(random, {.side = 8});
  support::add_contacts(random, {.share = 0.8, .degenerate = true, .edge_edge = 20}, problem);
  const QpResult result = solve(QpMethod::InteriorPoint, problem, {.max_iterations = 1});
  EXPECT_EQ(result.status, QpStatus::IterationLimit);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_EQ(result.q.size(), problem.f.size());
  EXPECT_TRUE(result.q.allFinite());
}

// It is asked before Ipopt.
TEST(InteriorPoint, AnswersWhereTheActiveSetGivesUp) {
  Random random(9);
  QpProblem problem = support::cloth_like(random, {.side = 8});
  support::add_contacts(random, {.share = 0.8}, problem);
  const QpResult result = solve(QpMethod::ActiveSet, problem, {.max_iterations = 1});
  ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
  EXPECT_TRUE(result.fell_back);
  EXPECT_EQ(result.q, solve(QpMethod::InteriorPoint, problem).q);
}

}  // namespace
}  // namespace crease
