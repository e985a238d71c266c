// SPDX-License-Identifier: MIT
// Answers: the other backend, the same problem from other starts, and the KKT residual.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "crease/solver/qp_solver.hpp"
#include "support/qp_problems.hpp"

namespace crease {
namespace {

using support::Contacts;
using support::objective;
using support::Random;
using support::RowBuilder;

QpResult solve(const QpProblem& problem, std::span<const char> guess = {}) {
  return make_qp_solver(QpMethod::ActiveSet)->solve(problem, {}, guess);
}

/// Stiffness over mass from that of a rag to that of a metal sheet.
QpProblem random_cloth(Random& random, const Contacts& contacts, int largest_side = 8) {
  support::ClothLike cloth;
  cloth.side = random.integer(2, largest_side);
  cloth.mass = std::pow(10, random.uniform(-6, -3));
  cloth.stiffness = cloth.mass * std::pow(10, random.uniform(-2, 6));
  QpProblem problem = support::cloth_like(random, cloth);
  support::add_contacts(random, contacts, problem);
  return problem;
}

/// From all active, none active and a random guess. The optimum is unique in q, so all three have to meet it.
void expect_one_optimum(const QpProblem& problem, Random& random) {
  const std::vector<char> none(static_cast<size_t>(problem.b_in.size()), 0);
  const std::vector<char> some = random.flags(problem.b_in.size());
  const QpResult first = solve(problem);
  ASSERT_EQ(first.status, QpStatus::Solved) << first.message;
  for (const std::vector<char>* guess : {&none, &some}) {
    const QpResult other = solve(problem, *guess);
    ASSERT_EQ(other.status, QpStatus::Solved) << other.message;
    // Both are optimal to a residual of 1e-9; the objective is flat there, q is off by the condition number times that.
    const double value = objective(problem, first.q);
    EXPECT_NEAR(objective(problem, other.q), value, 1e-8 * std::abs(value));
    EXPECT_LE(other.kkt_residual, 1e-9);
  }
  EXPECT_LE(first.kkt_residual, 1e-9);
  EXPECT_EQ(first.kkt_residual, kkt_residual(problem, first.q, first.lambda_eq, first.lambda_in));
}

TEST(ActiveSetQp, AgreesWithIpoptOnRandomProblems) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const int n = random.integer(2, 12);
    const QpProblem problem = support::random_dense(random, n, random.integer(0, n / 2), random.integer(0, 15));
    const QpResult ours = solve(problem), theirs = make_qp_solver(QpMethod::Ipopt)->solve(problem);
    ASSERT_EQ(ours.status, QpStatus::Solved) << ours.message;
    ASSERT_EQ(theirs.status, QpStatus::Solved) << theirs.message;
    // H >= 0.1, so q is as good as the residual of either, 1e-8 of numbers about 10, times ten.
    EXPECT_LE((ours.q - theirs.q).lpNorm<Eigen::Infinity>(), 1e-6);
  }
}

TEST(ActiveSetQp, AgreesWithIpoptOnCloth) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const QpProblem problem = random_cloth(random, {.share = 0.5, .edge_edge = 6, .general_eq = 2});
    const QpResult ours = solve(problem);
    // Ipopt is asked for less: on stiff problems its own rounding stops it.
    const QpResult theirs = make_qp_solver(QpMethod::Ipopt)->solve(problem, {.tolerance = 1e-6});
    ASSERT_EQ(ours.status, QpStatus::Solved) << ours.message;
    ASSERT_EQ(theirs.status, QpStatus::Solved) << theirs.message;
    const double value = objective(problem, ours.q);
    EXPECT_NEAR(objective(problem, theirs.q), value, 1e-5 * std::abs(value));
  }
}

TEST(ActiveSetQp, FindsOneOptimumFromAnyStartOnCloth) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const QpProblem problem = random_cloth(random, {.share = random.uniform(0, 1)});
    expect_one_optimum(problem, random);
  }
}

TEST(ActiveSetQp, FindsOneOptimumWithRepeatedOppositeParallelAndSurplusNormals) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const QpProblem problem =
        random_cloth(random, {.share = random.uniform(0.2, 1), .pinned = 0.1, .degenerate = true});
    expect_one_optimum(problem, random);
  }
}

TEST(ActiveSetQp, FindsOneOptimumWithGeneralRowsEvenDependentOnes) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Contacts contacts{.share = 0.4,
                            .pinned = 0.05,
                            .degenerate = true,
                            .edge_edge = random.integer(1, 30),
                            .general_eq = random.integer(0, 4)};
    const QpProblem problem = random_cloth(random, contacts);
    expect_one_optimum(problem, random);
  }
}

TEST(ActiveSetQp, FindsOneOptimumWithManyMoreRowsThanUnknowns) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const QpProblem problem = support::random_dense(random, random.integer(2, 6), 0, random.integer(20, 80));
    expect_one_optimum(problem, random);
  }
}

TEST(ActiveSetQp, TreatsBlocksTooLargeForABasisAsSingleUnknowns) {
  Random random(3);
  QpProblem problem = support::random_dense(random, 12, 2, 8);
  const QpResult expected = solve(problem);
  problem.blocks = {0, 12};
  const QpResult result = solve(problem);
  ASSERT_EQ(result.status, QpStatus::Solved);
  EXPECT_LE((result.q - expected.q).norm(), 1e-9 * expected.q.norm());
}

/// Flips every wrong sign at once, u >= 0, and says whether a set came back before the right one was found.
bool plain_exchange_cycles(const MatX& H, const VecX& f) {
  std::vector<std::vector<char>> seen(1, std::vector<char>(static_cast<size_t>(f.size()), 1));
  for (;;) {
    std::vector<char> held = seen.back();
    MatX K = H;
    VecX r = f;
    for (int i = 0; i < f.size(); ++i)
      if (held[i]) K.row(i) = VecX::Unit(f.size(), i).transpose(), r[i] = 0;
    const VecX u = K.inverse() * r, g = H * u - f;
    bool right = true;
    for (int i = 0; i < f.size(); ++i)
      if ((held[i] ? g[i] : u[i]) < -1e-12) held[i] ^= 1, right = false;
    if (right) return false;
    if (std::find(seen.begin(), seen.end(), held) != seen.end()) return true;
    seen.push_back(held);
  }
}

TEST(ActiveSetQp, EndsWherePlainBlockExchangeCycles) {
  // Known three-unknown example of a cycling primal-dual active set [CURTIS15], u = -x. The cycle has
  // three sets; several copies on the diagonal cycle in step.
  const MatX H = (MatX(3, 3) << 4, 5, -5, 5, 9, -5, -5, -5, 7).finished();
  const VecX f = (VecX(3) << 2, 1, -3).finished();
  ASSERT_TRUE(plain_exchange_cycles(H, f));
  for (const int copies : {1, 20}) {
    SCOPED_TRACE(copies);
    const int n = 3 * copies;
    MatX H_all = MatX::Zero(n, n);
    for (int k = 0; k < copies; ++k) H_all.block(3 * k, 3 * k, 3, 3) = H;
    const QpProblem problem =
        support::dense_problem(H_all, f.replicate(copies, 1), MatX(0, n), VecX(), MatX::Identity(n, n), VecX::Zero(n));
    const QpResult result = solve(problem);
    ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
    EXPECT_LE(result.kkt_residual, 1e-12);
    EXPECT_GT(result.iterations, 6) << "the backup was not needed";
  }
}

TEST(ActiveSetQp, NeedsOneFactorisationForEqualitiesOnly) {
  Random random(5);
  const QpProblem problem = random_cloth(random, {.share = 0, .pinned = 0.2});
  const QpResult result = solve(problem);
  ASSERT_EQ(result.status, QpStatus::Solved);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_LE(result.kkt_residual, 1e-11);
}

TEST(ActiveSetQp, SolvesWithoutConstraintsAndWithoutUnknowns) {
  Random random(6);
  const QpProblem problem = support::random_dense(random, 5, 0, 0);
  const QpResult result = solve(problem);
  ASSERT_EQ(result.status, QpStatus::Solved);
  EXPECT_LE((MatX(problem.H) * result.q - problem.f).norm(), 1e-13 * problem.f.norm());
  QpProblem empty;
  EXPECT_EQ(solve(empty).status, QpStatus::Solved);
}

/// One iteration finds the set right and is exact, as rows are not softened unless they depend on one another. More are
/// taken where stiffness (up to 1e6 of the mass here) leaves the residual above what needs no refinement.
TEST(ActiveSetQp, SeldomNeedsMoreThanOneIterationFromTheRightGuess) {
  int more = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    QpProblem problem = random_cloth(random, {.share = 0.6, .edge_edge = random.integer(0, 5)});
    const QpResult cold = solve(problem);
    ASSERT_EQ(cold.status, QpStatus::Solved);
    problem.f *= 1.0 + 1e-9;  // the next step is never quite the same
    const QpResult warm = solve(problem, cold.active);
    ASSERT_EQ(warm.status, QpStatus::Solved);
    EXPECT_LE(warm.iterations, 3);
    more += warm.iterations > 1;
  }
  EXPECT_LE(more, 3);
}

TEST(ActiveSetQp, MarksTheRowsThatPush) {
  Random random(8);
  const QpProblem problem = random_cloth(random, {.share = 0.8, .edge_edge = 4});
  const QpResult result = solve(problem);
  ASSERT_EQ(result.status, QpStatus::Solved);
  ASSERT_EQ(result.active.size(), static_cast<size_t>(problem.b_in.size()));
  for (int i = 0; i < problem.b_in.size(); ++i) EXPECT_TRUE(result.lambda_in[i] == 0 || result.active[i]) << i;
}

void expect_same_bytes(const QpResult& a, const QpResult& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_TRUE(a.q == b.q);
  EXPECT_TRUE(a.lambda_eq == b.lambda_eq);
  EXPECT_TRUE(a.lambda_in == b.lambda_in);
  EXPECT_EQ(a.active, b.active);
  EXPECT_EQ(a.iterations, b.iterations);
}

TEST(ActiveSetQp, GivesTheSameBytesFromAKeptSolverAsFromAFreshOne) {
  const auto kept = make_qp_solver(QpMethod::ActiveSet);
  for (const std::uint64_t seed : {1, 2, 2, 3, 1}) {
    SCOPED_TRACE(seed);
    Random random(seed);
    support::ClothLike cloth{.side = 12};
    const QpProblem other_pattern = random_cloth(random, {.edge_edge = 3});
    QpProblem problem = support::cloth_like(random, cloth);  // one pattern, new values for every seed
    support::add_contacts(random, {.degenerate = true, .edge_edge = 10, .general_eq = 2}, problem);
    const QpResult fresh = solve(problem);
    ASSERT_EQ(fresh.status, QpStatus::Solved);
    expect_same_bytes(kept->solve(problem), fresh);
    expect_same_bytes(kept->solve(problem), fresh);
    if (seed == 3) kept->solve(other_pattern);
  }
}

TEST(ActiveSetQp, IsNotMisledByAProblemThatNeverGotToItsFactorisation) {
  Random random(4);
  const QpProblem problem = random_cloth(random, {});
  QpProblem other = support::cloth_like(random, {.side = 9});
  const QpResult fresh = solve(other);
  const QpProblem feasible = other;
  RowBuilder eq(other.f.size());
  eq.add(0, Vec3(1, 0, 0), 0.0);
  eq.add(0, Vec3(1, 0, 0), 1.0);
  eq.finish(other.A_eq, other.b_eq);
  const auto kept = make_qp_solver(QpMethod::ActiveSet);
  EXPECT_EQ(kept->solve(problem).status, QpStatus::Solved);
  EXPECT_EQ(kept->solve(other).status, QpStatus::Infeasible);
  expect_same_bytes(kept->solve(feasible), fresh);
}

}  // namespace
}  // namespace crease
