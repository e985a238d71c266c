// SPDX-License-Identifier: MIT
// What the border of a working set is made of, against dense algebra: inside the library, for the solver runs only the
// kernels of the processor at hand.
#include "half_solves.hpp"

#include <gtest/gtest.h>

#include "find_kernels.hpp"
#include "multifrontal.hpp"
#include "support/block_matrices.hpp"

namespace crease {
namespace {

using support::Random;

/// Rounding of sums of products of L^-1 C, relative to their sizes: n eps times the condition, which random_spd() keeps
/// below 1e3 or so.
constexpr double rounding = 1e-11;

/// One entry a column here and there, some columns with more, one empty; none in the row of a held unknown.
SparseMatrix sparse_columns(Random& random, const std::vector<char>& held, int n_columns) {
  const int n = static_cast<int>(held.size());
  SparseMatrix C(n, n_columns);
  for (int j = 0; j < n_columns; ++j) {
    if (j % 7 == 3) continue;
    for (int i = n > 0 ? (j * 31) % n : 0; i < n; i += j % 2 == 0 ? n : 17)
      if (!held[i]) C.insert(i, j) = random.uniform(-1, 1);
  }
  C.makeCompressed();
  return C;
}

void expect_near(const MatX& given, const MatX& exact) {
  ASSERT_EQ(given.rows(), exact.rows());
  EXPECT_LE((given - exact).norm(), rounding * (1 + exact.norm()));
}

TEST(HalfSolves, AgreeWithDenseAlgebraUnderEverySetOfKernels) {
  for (const FrontKernelSet set : available_front_kernels())
    for (const auto& [name, graph] : support::block_graphs()) {
      SCOPED_TRACE(name + ", " + to_string(set));
      Random random(11);
      const auto matrix = support::random_spd(random, graph);
      std::vector<char> held(static_cast<std::size_t>(graph.n_unknowns()), 0);
      for (std::size_t i = 0; i < held.size(); i += 5) held[i] = 1;
      const FrontKernels& kernels = find_front_kernels(set);
      Multifrontal factor(kernels, 1);
      ASSERT_TRUE(factor.analyze(matrix.graph, {}));
      ASSERT_TRUE(factor.factorize(matrix.A, held, 0));
      HalfSolves Y(kernels);
      MatX dense(factor.n_free(), 0), gram(0, 0);
      Y.clear(factor.n_free());
      for (const int n_columns :
           {1, 30, 8, 49}) {  // one panel hardly begun, two batches, one panel full, three batches
        const SparseMatrix C = sparse_columns(random, held, n_columns);
        const int first = Y.n_columns();
        factor.forward(C, Y);
        ASSERT_EQ(Y.n_columns(), first + 8 * ((n_columns + 7) / 8));
        dense.conservativeResize(Eigen::NoChange, Y.n_columns());
        dense.rightCols(Y.n_columns() - first).setZero();
        dense.middleCols(first, n_columns) = factor.forward(MatX(C)).topRows(factor.n_free());
        gram.conservativeResize(Y.n_columns(), Y.n_columns());
        Y.fill_gram(first, gram);
        expect_near(gram, dense.transpose() * dense);
        EXPECT_EQ(gram, MatX(gram.transpose()));
      }
      const VecX z = random.vector(Y.n_columns()), y = random.vector(factor.n_free());
      VecX x = y;
      Y.subtract_product(z, x);
      expect_near(x, y - dense * z);
      expect_near(Y.transposed_product(y), dense.transpose() * y);
    }
}

}  // namespace
}  // namespace crease
