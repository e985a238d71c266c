// SPDX-License-Identifier: MIT
#include "crease/solver/block_cholesky.hpp"

#include <amd.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "support/block_matrices.hpp"

namespace crease {
namespace {

using support::BlockMatrix;
using support::Random;

/// Every implementation, under every set of kernels that this processor runs.
class EachCholesky : public testing::TestWithParam<CholeskyOptions> {
 protected:
  std::unique_ptr<BlockCholesky> make() const { return make_block_cholesky(GetParam()); }
};

std::vector<CholeskyOptions> all_options() {
  std::vector<CholeskyOptions> options{{CholeskyMethod::Cholmod, FrontKernelSet::Best}};
  for (const FrontKernelSet kernels : available_front_kernels())
    options.push_back({CholeskyMethod::Multifrontal, kernels});
  return options;
}

std::string name_of(const testing::TestParamInfo<CholeskyOptions>& backend) {
  if (backend.param.method == CholeskyMethod::Cholmod) return "Cholmod";
  std::string name = to_string(backend.param.kernels);
  std::erase(name, '-');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Backends, EachCholesky, testing::ValuesIn(all_options()), name_of);

/// Rounding of a backward stable solve relative to the solution: n eps times the condition, which random_spd() keeps
/// below 1e3 or so.
constexpr double rounding = 1e-11;

/// Solves with the factor, and sees to it that the two halves are L^-1 P and its transpose.
void expect_solves(const BlockCholesky& factor, const MatX& K, const MatX& B) {
  const MatX exact = K.llt().solve(B);
  const MatX Y = factor.forward(B), X = factor.backward(Y);
  ASSERT_EQ(Y.rows(), K.rows());
  ASSERT_EQ(X.cols(), B.cols());
  if (B.size() == 0) return;
  EXPECT_LE((X - exact).norm(), rounding * exact.norm());
  EXPECT_LE((Y.transpose() * Y - B.transpose() * exact).norm(), rounding * (B.norm() * exact.norm()));  // B^T K^-1 B
}

/// K with identity rows for what is held.
MatX masked(MatX K, const std::vector<char>& held, double lift) {
  K.diagonal().array() += lift;
  for (int i = 0; i < K.rows(); ++i)
    if (held[i]) {
      K.row(i).setZero();
      K.col(i).setZero();
      K(i, i) = 1;
    }
  return K;
}

TEST_P(EachCholesky, AgreesWithADenseFactorisationOnEveryGraph) {
  const auto factor = make();
  for (const auto& [name, graph] : support::block_graphs()) {
    SCOPED_TRACE(name);
    Random random(7);
    const BlockMatrix matrix = support::random_spd(random, graph);
    ASSERT_TRUE(factor->analyze(matrix.graph));
    ASSERT_TRUE(factor->factorize(matrix.A));
    // One column, a panel not full, exactly one, several batches.
    for (const int columns : {1, 2, 5, 8, 61})
      expect_solves(*factor, MatX(matrix.A), random.matrix(graph.n_unknowns(), columns));
  }
}

TEST_P(EachCholesky, TakesHeldUnknownsForIdentityRows) {
  const auto factor = make();
  for (const auto& [name, graph] : support::block_graphs()) {
    SCOPED_TRACE(name);
    Random random(11);
    const BlockMatrix matrix = support::random_spd(random, graph);
    const int n = graph.n_unknowns();
    ASSERT_TRUE(factor->analyze(matrix.graph));
    for (const double share : {0.1, 0.5, 0.9, 1.0}) {
      std::vector<char> held(static_cast<std::size_t>(n));
      for (char& flag : held) flag = random.uniform(0, 1) <= share;
      ASSERT_TRUE(factor->factorize(matrix.A, held, 0.25));
      for (const int columns : {1, 9})
        expect_solves(*factor, masked(MatX(matrix.A), held, 0.25), random.matrix(n, columns));
    }
    ASSERT_TRUE(factor->factorize(matrix.A));  // nothing of it stays
    expect_solves(*factor, MatX(matrix.A), random.matrix(n, 3));
  }
}

TEST_P(EachCholesky, SolvesFewEntriesAsWellAsMany) {
  Random random(3);
  const BlockMatrix matrix = support::random_spd(random, support::grid_graph(9, 9));
  const int n = matrix.graph.n_unknowns();
  const auto factor = make();
  ASSERT_TRUE(factor->analyze(matrix.graph));
  ASSERT_TRUE(factor->factorize(matrix.A));
  MatX B = MatX::Zero(n, 30);  // a few columns stay empty
  for (int j = 0; j < 25; ++j) B(random.integer(0, n - 1), j) = 1;
  expect_solves(*factor, MatX(matrix.A), B);
}

TEST_P(EachCholesky, ReportsWhatIsNotPositiveDefinite) {
  Random random(5);
  const BlockMatrix good = support::random_spd(random, support::grid_graph(6, 6));
  const int n = good.graph.n_unknowns();
  const auto factor = make();
  ASSERT_TRUE(factor->analyze(good.graph));
  constexpr double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  for (const int unknown : {0, n / 2, n - 1})
    for (const double bad : {0.0, -1.0, nan, inf, -inf}) {
      SCOPED_TRACE(testing::Message() << bad << " at " << unknown);
      SparseMatrix A = good.A;
      A.coeffRef(unknown, unknown) = bad;
      EXPECT_FALSE(factor->factorize(A));
      EXPECT_EQ(factor->rcond(), 0);
      std::vector<char> held(static_cast<std::size_t>(n), 0);
      held[unknown] = 1;  // what is held is not looked at
      EXPECT_TRUE(factor->factorize(A, held));
      ASSERT_TRUE(factor->factorize(good.A));  // and no failure spoils what follows
      expect_solves(*factor, MatX(good.A), random.matrix(n, 2));
    }
  for (const double bad : {nan, inf, 1e200}) {
    SCOPED_TRACE(bad);
    SparseMatrix A = good.A;
    A.coeffRef(0, 1) = A.coeffRef(1, 0) = bad;
    EXPECT_FALSE(factor->factorize(A));
  }
}

TEST_P(EachCholesky, LiftsASingularMatrix) {
  const BlockGraph graph = support::path_graph(12);
  SparseMatrix A = make_block_matrix(graph);
  const auto factor = make();
  ASSERT_TRUE(factor->analyze(graph));
  EXPECT_FALSE(factor->factorize(A));
  ASSERT_TRUE(factor->factorize(A, {}, 4.0));
  EXPECT_DOUBLE_EQ(factor->rcond(), 1);
  const VecX b = VecX::LinSpaced(graph.n_unknowns(), 1, 2);
  EXPECT_LE((factor->solve(b) - b / 4).norm(), 1e-15 * b.norm());
}

TEST_P(EachCholesky, GivesTheSameBytesWhateverItFactorisedBefore) {
  Random random(13);
  const BlockMatrix matrix = support::random_spd(random, support::grid_graph(8, 8));
  const BlockMatrix other = support::random_spd(random, support::random_graph(40, 100, 2));
  const MatX B = random.matrix(matrix.graph.n_unknowns(), 11);
  std::vector<char> held(static_cast<std::size_t>(B.rows()), 0);
  for (std::size_t i = 0; i < held.size(); i += 3) held[i] = 1;
  const auto fresh = make(), used = make();
  ASSERT_TRUE(fresh->analyze(matrix.graph));
  ASSERT_TRUE(fresh->factorize(matrix.A, held));
  ASSERT_TRUE(used->analyze(other.graph));
  ASSERT_TRUE(used->factorize(other.A));
  ASSERT_TRUE(used->analyze(matrix.graph));
  ASSERT_TRUE(used->factorize(matrix.A));
  EXPECT_FALSE(used->factorize(-matrix.A));
  ASSERT_TRUE(used->factorize(matrix.A, held));
  EXPECT_EQ(used->forward(B), fresh->forward(B));
  EXPECT_EQ(used->solve(B), fresh->solve(B));
  EXPECT_EQ(used->rcond(), fresh->rcond());
}

TEST_P(EachCholesky, KeepsAGivenOrderAndRefusesABadOne) {
  Random random(17);
  const BlockMatrix matrix = support::random_spd(random, support::grid_graph(20, 20));
  const auto factor = make();
  ASSERT_TRUE(factor->analyze(matrix.graph));
  const double best = factor->cost().flops;
  ASSERT_TRUE(factor->analyze(matrix.graph, factor->order()));
  EXPECT_DOUBLE_EQ(factor->cost().flops, best);
  std::vector<int> rows(static_cast<std::size_t>(matrix.graph.n_blocks()));
  std::iota(rows.begin(), rows.end(), 0);
  ASSERT_TRUE(factor->analyze(matrix.graph, rows));
  EXPECT_GT(factor->cost().flops, best);  // row by row fills the band
  ASSERT_TRUE(factor->factorize(matrix.A));
  expect_solves(*factor, MatX(matrix.A), random.matrix(matrix.graph.n_unknowns(), 2));
  rows[3] = 4;
  EXPECT_THROW(factor->analyze(matrix.graph, rows), std::invalid_argument);
  rows.pop_back();
  EXPECT_THROW(factor->analyze(matrix.graph, rows), std::invalid_argument);
}

TEST_P(EachCholesky, SolvesInAnyOrder) {
  // Drawn orders are no postorders, and columns of one supernode stand far apart in them.
  const auto factor = make();
  for (const auto& [name, graph] : support::block_graphs()) {
    SCOPED_TRACE(name);
    Random random(19);
    const BlockMatrix matrix = support::random_spd(random, graph);
    std::vector<int> order(static_cast<std::size_t>(graph.n_blocks()));
    std::iota(order.begin(), order.end(), 0);
    for (int turn = 0; turn < 3; ++turn) {
      for (int k = graph.n_blocks() - 1; k > 0; --k) std::swap(order[k], order[random.integer(0, k)]);
      ASSERT_TRUE(factor->analyze(matrix.graph, order));
      const FactorCost needed = support::filled_cost(graph, order);
      EXPECT_GE(factor->cost().entries, needed.entries);
      EXPECT_GE(factor->cost().flops, needed.flops);
      ASSERT_TRUE(factor->factorize(matrix.A));
      expect_solves(*factor, MatX(matrix.A), random.matrix(graph.n_unknowns(), 2));
    }
  }
}

TEST_P(EachCholesky, RefusesMalformedGraphs) {
  const auto factor = make();
  const BlockGraph good = support::path_graph(4);
  const auto refuses = [&](auto&& spoil) {
    BlockGraph graph = good;
    spoil(graph);
    EXPECT_THROW(factor->analyze(graph), std::invalid_argument);
  };
  refuses([](BlockGraph& g) { g.starts[1] = g.starts[2]; });
  refuses([](BlockGraph& g) { g.starts[0] = 1; });
  refuses([](BlockGraph& g) { g.outer.pop_back(); });
  refuses([](BlockGraph& g) { g.inner.pop_back(); });
  refuses([](BlockGraph& g) { g.inner[0] = -1; });
  refuses([](BlockGraph& g) { g.inner.back() = 4; });
  refuses([](BlockGraph& g) { std::swap(g.inner[0], g.inner[1]); });
  refuses([](BlockGraph& g) { g.inner[1] = 2; });                        // 2 touches 0, but 0 does not touch 2
  refuses([](BlockGraph& g) { g.inner.pop_back(), --g.outer.back(); });  // 3 does not touch itself
  refuses([](BlockGraph& g) { g.inner.push_back(3), ++g.outer.back(); });
  refuses([](BlockGraph& g) {  // 3 touches 0, but 0 does not touch 3
    g.inner.insert(g.inner.end() - 2, 0);
    ++g.outer.back();
  });
}

TEST(Cholesky, CountsAtLeastTheFlopsThatItsOrderTakes) {
  // Counted column by column on the filled graph of the order it chose.
  for (const auto& [name, graph] : support::block_graphs()) {
    SCOPED_TRACE(name);
    const auto factor = make_block_cholesky();
    ASSERT_TRUE(factor->analyze(graph));
    const FactorCost needed = support::filled_cost(graph, factor->order());
    const FactorCost cost = factor->cost();
    EXPECT_GE(cost.entries, needed.entries);
    EXPECT_GE(cost.flops, needed.flops);
    const auto cholmod = make_block_cholesky({.method = CholeskyMethod::Cholmod});
    ASSERT_TRUE(cholmod->analyze(graph, factor->order()));
    EXPECT_GE(cholmod->cost().flops, needed.flops);
  }
}

TEST(BlockOrder, HasEachBlockOnceAndTheSameAgain) {
  for (const auto& [name, graph] : support::block_graphs())
    for (const BlockOrdering ordering : {BlockOrdering::MinimumDegree, BlockOrdering::NestedDissection}) {
      SCOPED_TRACE(name);
      const std::vector<int> order = make_block_order(graph, ordering);
      std::vector<int> sorted = order, blocks(static_cast<std::size_t>(graph.n_blocks()));
      std::sort(sorted.begin(), sorted.end());
      std::iota(blocks.begin(), blocks.end(), 0);
      EXPECT_EQ(sorted, blocks);
      EXPECT_EQ(make_block_order(graph, ordering), order);
    }
}

TEST(BlockOrder, OfMinimumDegreeLeavesTreesWithoutFill) {
  // A leaf has least degree, and a tree without it is a tree.
  Random random(29);
  std::vector<std::pair<int, int>> edges;
  for (int k = 1; k < 300; ++k) edges.emplace_back(random.integer(0, k - 1), k);
  const BlockGraph drawn = support::make_graph(300, edges, [](int) { return 1; });
  for (const BlockGraph& tree : {drawn, support::path_graph(50), support::star_graph(200, 7)}) {
    double n_entries = 0;
    for (int k = 0; k < tree.n_blocks(); ++k)
      for (int at = tree.outer[k]; at < tree.outer[k + 1]; ++at)
        n_entries += tree.inner[at] > k ? tree.size(k) * tree.size(tree.inner[at]) : 0;
    for (int k = 0; k < tree.n_blocks(); ++k) n_entries += tree.size(k) * (tree.size(k) + 1) / 2.0;
    EXPECT_EQ(support::filled_cost(tree, make_block_order(tree, BlockOrdering::MinimumDegree)).entries, n_entries);
  }
}

TEST(BlockOrder, OfMinimumDegreeIsAsGoodAsThatOfAmd) {
  // Ties are broken alike, except where lists that AMD has not cleared yet hide that two blocks are equal.
  std::vector<std::pair<std::string, BlockGraph>> graphs = support::block_graphs();
  graphs.emplace_back("square", support::grid_graph(35, 35));
  graphs.emplace_back("large random", support::random_graph(400, 900, 4));
  for (const auto& [name, graph] : graphs) {
    SCOPED_TRACE(name);
    std::vector<int> order(static_cast<std::size_t>(graph.n_blocks()));
    if (order.empty()) continue;  // which amd_order() refuses
    ASSERT_EQ(amd_order(graph.n_blocks(), graph.outer.data(), graph.inner.data(), order.data(), nullptr, nullptr), 0);
    const FactorCost cost = support::filled_cost(graph, make_block_order(graph, BlockOrdering::MinimumDegree));
    EXPECT_LE(cost.flops, 1.03 * support::filled_cost(graph, order).flops);
  }
}

TEST(BlockOrder, OfMinimumDegreePutsWhatTouchesNearlyAllLast) {
  std::vector<std::pair<int, int>> edges;
  for (int k = 0; k < 900; ++k) {
    if (k % 3 > 0) edges.emplace_back(400, k);
    if (k % 30 > 0) edges.emplace_back(k - 1, k);
    if (k >= 30) edges.emplace_back(k - 30, k);
  }
  const BlockGraph graph = support::make_graph(900, edges, support::three);
  EXPECT_EQ(make_block_order(graph, BlockOrdering::MinimumDegree).back(), 400);
}

TEST(BlockOrder, DissectsLargeGraphsToAdvantage) {
  const BlockGraph graph = support::grid_graph(150, 150);
  const auto factor = make_block_cholesky();
  const auto flops = [&](BlockOrdering ordering) {
    EXPECT_TRUE(factor->analyze(graph, make_block_order(graph, ordering)));
    return factor->cost().flops;
  };
  EXPECT_LT(flops(BlockOrdering::NestedDissection), 0.9 * flops(BlockOrdering::MinimumDegree));
}

TEST(Multifrontal, AgreesBetweenKernelsToRounding) {
  Random random(23);
  const BlockMatrix matrix = support::random_spd(random, support::grid_graph(12, 12));
  const MatX B = random.matrix(matrix.graph.n_unknowns(), 20);
  MatX first;
  for (const FrontKernelSet kernels : available_front_kernels()) {
    const auto factor = make_block_cholesky({.kernels = kernels});
    ASSERT_TRUE(factor->analyze(matrix.graph));
    ASSERT_TRUE(factor->factorize(matrix.A));
    const MatX Y = factor->forward(B);
    if (first.size() == 0) first = Y;
    EXPECT_LE((Y - first).norm(), rounding * first.norm());
  }
}

TEST(Multifrontal, GivesTheSameBytesOnAnyNumberOfThreads) {
  Random random(29);
  const BlockMatrix matrix = support::random_spd(random, support::grid_graph(45, 45));  // large enough to be shared out
  const MatX B = random.matrix(matrix.graph.n_unknowns(), 2);
  std::vector<char> held(static_cast<std::size_t>(B.rows()), 0);
  for (std::size_t i = 0; i < held.size(); i += 5) held[i] = 1;
  SparseMatrix bad = matrix.A;
  bad.coeffRef(0, 0) = -1;
  MatX one;
  for (const int threads : {1, 2, 3, 7}) {
    SCOPED_TRACE(threads);
    const auto factor = make_block_cholesky({.threads = threads});
    ASSERT_TRUE(factor->analyze(matrix.graph));
    EXPECT_FALSE(factor->factorize(bad));
    ASSERT_TRUE(factor->factorize(matrix.A));
    MatX both(B.rows(), 4);
    both.leftCols(2) = factor->forward(B);
    ASSERT_TRUE(factor->factorize(matrix.A, held));
    both.rightCols(2) = factor->forward(B);
    if (one.size() == 0) one = both;
    EXPECT_EQ(both, one);
  }
  EXPECT_THROW(make_block_cholesky({.threads = 0}), std::invalid_argument);
}

TEST(Multifrontal, RefusesKernelsOfAnotherProcessor) {
  const std::vector<FrontKernelSet> available = available_front_kernels();
  for (const FrontKernelSet kernels : {FrontKernelSet::Generic, FrontKernelSet::Avx2, FrontKernelSet::Avx512}) {
    if (std::find(available.begin(), available.end(), kernels) == available.end())
      EXPECT_THROW(make_block_cholesky({.kernels = kernels}), std::invalid_argument);
    else
      EXPECT_NE(make_block_cholesky({.kernels = kernels}), nullptr);
  }
}

}  // namespace
}  // namespace crease
