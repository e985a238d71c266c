// SPDX-License-Identifier: MIT
#include "crease/solver/linear_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>
#include <stdexcept>

#include "support/qp_problems.hpp"

namespace crease {
namespace {

using support::Random;

TEST(LinearSolver, AgreesWithADenseFactorisationWhateverItSolvedBefore) {
  LinearSolver solver;
  for (const int side : {4, 7, 7, 5}) {
    SCOPED_TRACE(side);
    Random random(static_cast<std::uint64_t>(side));
    const QpProblem problem = support::cloth_like(random, {.side = side});
    const QpResult result = solver.solve(problem);
    ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
    EXPECT_EQ(result.iterations, 0);
    EXPECT_LE(result.kkt_residual, 1e-12);
    const VecX dense = MatX(problem.H).ldlt().solve(problem.f);
    EXPECT_LE((result.q - dense).norm(), 1e-9 * dense.norm());  // the condition of H is about 1e6
    LinearSolver fresh;
    EXPECT_EQ(fresh.solve(problem).q, result.q);
  }
}

TEST(LinearSolver, ReportsWhatIsNotPositiveDefinite) {
  for (const double last : {0.0, -1.0}) {
    MatX H = MatX::Identity(3, 3);
    H(2, 2) = last;
    const QpResult result =
        LinearSolver().solve(support::dense_problem(H, VecX::Ones(3), MatX(), VecX(), MatX(), VecX()));
    EXPECT_EQ(result.status, QpStatus::NumericalTrouble);
    EXPECT_EQ(result.q.size(), 0);
    EXPECT_NE(result.message.find("positive definite"), std::string::npos) << result.message;
  }
}

TEST(LinearSolver, RefusesConstraintsAndNumbersThatAreNone) {
  const MatX H = MatX::Identity(2, 2);
  EXPECT_THROW(
      LinearSolver().solve(support::dense_problem(H, VecX::Ones(2), MatX::Ones(1, 2), VecX::Ones(1), MatX(), VecX())),
      std::invalid_argument);
  EXPECT_THROW(
      LinearSolver().solve(support::dense_problem(H, VecX::Ones(2), MatX(), VecX(), MatX::Ones(1, 2), VecX::Ones(1))),
      std::invalid_argument);
  EXPECT_THROW(LinearSolver().solve(support::dense_problem(
                   H, VecX::Constant(2, std::numeric_limits<double>::quiet_NaN()), MatX(), VecX(), MatX(), VecX())),
               std::invalid_argument);
}

TEST(LinearSolver, RestsAtZeroAndTakesNoUnknowns) {
  const QpResult rest =
      LinearSolver().solve(support::dense_problem(MatX::Identity(2, 2), VecX::Zero(2), MatX(), VecX(), MatX(), VecX()));
  EXPECT_EQ(rest.status, QpStatus::Solved);
  EXPECT_EQ(rest.q, VecX::Zero(2));
  EXPECT_EQ(LinearSolver().solve({}).status, QpStatus::Solved);
}

}  // namespace
}  // namespace crease
