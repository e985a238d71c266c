// SPDX-License-Identifier: MIT
#include "crease/solver/qp.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "crease/solver/linear_solver.hpp"
#include "crease/solver/qp_solver.hpp"
#include "support/qp_problems.hpp"

namespace crease {
namespace {

using support::dense_problem;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// minimise q0^2 + q1^2 - 2 q0 - 6 q1 with q0 + q1 = 2 and q1 >= 3: q = (-1, 3), by hand lambda_eq = -4, lambda_in = 4.
QpProblem by_hand() {
  const MatX A_eq = MatX::Ones(1, 2), A_in = (MatX(1, 2) << 0, 1).finished();
  return dense_problem(2 * MatX::Identity(2, 2), (VecX(2) << 2, 6).finished(), A_eq, VecX::Constant(1, 2), A_in,
                       VecX::Constant(1, 3));
}

struct Point {
  VecX q = (VecX(2) << -1, 3).finished(), eq = VecX::Constant(1, -4), in = VecX::Constant(1, 4);
};

TEST(KktResidual, VanishesAtTheSolutionOnly) {
  const QpProblem problem = by_hand();
  const Point p;
  EXPECT_EQ(kkt_residual(problem, p.q, p.eq, p.in), 0);
  EXPECT_GT(kkt_residual(problem, p.q + VecX::Constant(2, 0.01), p.eq, p.in), 1e-4) << "primal";
  EXPECT_GT(kkt_residual(problem, p.q, p.eq * 1.01, p.in), 1e-4) << "stationarity";
  // q1 >= 2 is met with slack, so its multiplier has to vanish.
  QpProblem loose = problem;
  loose.b_in[0] = 2;
  EXPECT_GT(kkt_residual(loose, p.q, p.eq, p.in), 1e-2) << "complementarity";
  // Turned around and shifted to be tight, the row would have to pull.
  QpProblem pulling = problem;
  pulling.A_in *= -1;
  pulling.b_in *= -1;
  EXPECT_GT(kkt_residual(pulling, p.q, p.eq, -p.in), 1e-2) << "dual";
}

TEST(KktResidual, DependsNeitherOnUnitsNorOnTheScaleOfARow) {
  QpProblem problem = by_hand();
  const Point p;
  const VecX near = p.q + (VecX(2) << 1e-3, -2e-3).finished();
  const double residual = kkt_residual(problem, near, p.eq, p.in);
  problem.H *= 1e-6;  // another unit of mass
  problem.f *= 1e-6;
  EXPECT_NEAR(kkt_residual(problem, near, 1e-6 * p.eq, 1e-6 * p.in), residual, 1e-12);
  problem.A_in *= 1e5;
  problem.b_in *= 1e5;
  EXPECT_NEAR(kkt_residual(problem, near, 1e-6 * p.eq, 1e-11 * p.in), residual, 1e-12);
}

TEST(KktResidual, IsInfiniteForNumbersThatAreNotFinite) {
  const QpProblem problem = by_hand();
  const Point p;
  EXPECT_TRUE(std::isinf(kkt_residual(problem, VecX::Constant(2, nan), p.eq, p.in)));
  EXPECT_TRUE(std::isinf(kkt_residual(problem, p.q, VecX::Constant(1, nan), p.in)));
  EXPECT_TRUE(std::isinf(kkt_residual(problem, p.q, p.eq, VecX::Constant(1, nan))));
  EXPECT_TRUE(std::isinf(kkt_residual(problem, p.q, p.eq, VecX())));
}

TEST(RequireValid, AcceptsWhatTheAssemblyMakes) {
  support::Random random(1);
  QpProblem problem = support::cloth_like(random, {});
  support::add_contacts(random, {}, problem);
  EXPECT_NO_THROW(require_valid(problem));
  EXPECT_NO_THROW(require_valid(by_hand()));
}

TEST(RequireValid, RejectsMalformedProblems) {
  const auto rejects = [](auto spoil) {
    QpProblem problem = by_hand();
    spoil(problem);
    EXPECT_THROW(require_valid(problem), std::invalid_argument);
    for (const QpMethod method : {QpMethod::ActiveSet, QpMethod::InteriorPoint, QpMethod::Ipopt})
      EXPECT_THROW(make_qp_solver(method)->solve(problem), std::invalid_argument);
  };
  rejects([](QpProblem& p) { p.f[0] = nan; });
  rejects([](QpProblem& p) { p.f.conservativeResize(3); });
  rejects([](QpProblem& p) { p.H.coeffRef(0, 0) = nan; });
  rejects([](QpProblem& p) { p.H.coeffRef(1, 1) = std::numeric_limits<double>::infinity(); });
  rejects([](QpProblem& p) { p.H.insert(0, 1) = 1, p.H.makeCompressed(); });  // upper triangle only
  rejects([](QpProblem& p) { p.H.insert(1, 0) = 1, p.H.makeCompressed(); });  // lower triangle only
  rejects([](QpProblem& p) { p.H.insert(1, 0) = 1, p.H.insert(0, 1) = 2, p.H.makeCompressed(); });
  rejects([](QpProblem& p) { p.b_eq[0] = nan; });
  rejects([](QpProblem& p) { p.b_in[0] = -std::numeric_limits<double>::infinity(); });
  rejects([](QpProblem& p) { p.A_in.coeffRef(0, 1) = nan; });
  rejects([](QpProblem& p) { p.A_in = SparseRows(1, 3); });
  rejects([](QpProblem& p) { p.A_eq = SparseRows(2, 2); });
  rejects([](QpProblem& p) { p.blocks = {0, 1}; });
  rejects([](QpProblem& p) { p.blocks = {0, 1, 1, 2}; });
  rejects([](QpProblem& p) { p.blocks = {1, 2}; });
}

// A solver that has met the pattern before does not go through it again, but through the values; with blocks stored
// whole and with holes in them.
TEST(QpSolver, RejectsMalformedValuesInAPatternItKnows) {
  support::Random random(2);
  QpProblem whole = support::cloth_like(random, {.side = 4}), holes = whole;
  holes.H = SparseMatrix(holes.H.rows(), holes.H.cols());
  holes.H.setIdentity();
  for (QpProblem* problem : {&whole, &holes}) {
    for (const int first : {0, 31}) {
      const auto solver = make_qp_solver(QpMethod::ActiveSet);
      LinearSolver linear;
      ASSERT_EQ(solver->solve(*problem).status, QpStatus::Solved);
      ASSERT_EQ(linear.solve(*problem).status, QpStatus::Solved);
      QpProblem spoilt = *problem;
      spoilt.H.valuePtr()[first] = nan;
      EXPECT_THROW(solver->solve(spoilt), std::invalid_argument);
      EXPECT_THROW(linear.solve(spoilt), std::invalid_argument);
      EXPECT_EQ(solver->solve(*problem).status, QpStatus::Solved);
    }
  }
  const auto solver = make_qp_solver(QpMethod::ActiveSet);
  for (int column = 0; column < 3; ++column)
    for (SparseMatrix::InnerIterator entry(whole.H, column); entry; ++entry) {
      if (entry.row() == column) continue;
      SCOPED_TRACE(entry.row());
      ASSERT_EQ(solver->solve(whole).status, QpStatus::Solved);
      QpProblem spoilt = whole;
      spoilt.H.coeffRef(entry.row(), column) += 1e-6 * whole.H.diagonal().maxCoeff();
      EXPECT_THROW(solver->solve(spoilt), std::invalid_argument);
    }
}

TEST(QpSolver, RejectsMalformedOptionsAndGuesses) {
  for (const QpMethod method : {QpMethod::ActiveSet, QpMethod::InteriorPoint, QpMethod::Ipopt}) {
    const auto solver = make_qp_solver(method);
    EXPECT_THROW(solver->solve(by_hand(), {}, std::vector<char>(2)), std::invalid_argument);
    EXPECT_THROW(solver->solve(by_hand(), {.tolerance = 0}), std::invalid_argument);
    EXPECT_THROW(solver->solve(by_hand(), {.max_iterations = 0}), std::invalid_argument);
    EXPECT_THROW(solver->solve(by_hand(), {.tolerance = nan}), std::invalid_argument);
  }
}

TEST(QpStatusName, NamesEachStatus) {
  EXPECT_STREQ(to_string(QpStatus::Solved), "solved");
  EXPECT_STREQ(to_string(QpStatus::Infeasible), "infeasible");
  EXPECT_STREQ(to_string(QpStatus::Unbounded), "unbounded");
  EXPECT_STREQ(to_string(QpStatus::IterationLimit), "iteration limit");
  EXPECT_STREQ(to_string(QpStatus::NumericalTrouble), "numerical trouble");
}

}  // namespace
}  // namespace crease
