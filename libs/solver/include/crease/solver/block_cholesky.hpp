// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "crease/base/types.hpp"

namespace crease {

/// The unknowns in blocks (one a vertex), and which blocks touch.
struct BlockGraph {
  std::vector<int> starts{0};  ///< strictly ascending first unknowns, last entry n
  std::vector<int> outer{0};   ///< compressed columns of the graph: both triangles and the diagonal, ascending
  std::vector<int> inner;

  int n_blocks() const { return static_cast<int>(starts.size()) - 1; }
  int n_unknowns() const { return starts.back(); }
  int size(int block) const { return starts[block + 1] - starts[block]; }
};

/// The matrix of a graph, all zero: every entry of every block is stored.
SparseMatrix make_block_matrix(const BlockGraph& graph);

enum class BlockOrdering {
  MinimumDegree,    ///< approximate minimum degree [AMESTOY96]: takes little time
  NestedDissection  ///< METIS [KARYPIS98]: fewer flops on large graphs, but takes about ten times as long
};

/// An order of elimination of the blocks that leaves L sparse. Same graph, same order. Where CHOLMOD was built without
/// METIS it is one of minimum degree. Throws std::invalid_argument if the graph is malformed, std::bad_alloc.
std::vector<int> make_block_order(const BlockGraph& graph, BlockOrdering ordering);

/// What a factorisation P A P^T = L L^T takes.
struct FactorCost {
  double entries = 0;  ///< of L
  double flops = 0;    ///< sum of the squared column lengths of L: a multiplication and an addition each count one

  /// Flops of the factorisation over those of half a solve with one right-hand side.
  double ratio() const { return entries > 0 ? flops / (2 * entries) : 0; }
};

/// Cholesky factorisation of a sparse symmetric matrix of blocks. The analysis is kept until the next analyze();
/// factorize() may be called with new values any number of times.
///
/// Unknowns may be *held*: their rows and columns count as those of the identity, without a new analysis.
/// Same calls, same bytes.
class BlockCholesky {
 public:
  virtual ~BlockCholesky() = default;

  /// @param order  in which to eliminate the blocks; empty = the one that makes analysis and one factorisation
  /// cheapest,
  ///               which is minimum degree up to 50 000 blocks. An order made for a slightly different graph stays
  ///               good: cost() tells how good.
  /// Throws std::invalid_argument if the graph or the order is malformed.
  /// @return false if out of memory
  virtual bool analyze(const BlockGraph& graph, std::span<const int> order = {}) = 0;
  /// The order of the last analysis, to be given to another.
  virtual const std::vector<int>& order() const = 0;

  /// A + lift I, with identity rows for the held unknowns.
  /// @param A     of the pattern of make_block_matrix(graph); only one triangle is read
  /// @param held  one an unknown; empty = none
  /// @return false if that is not positive definite to working precision, or not finite; there is then no factor
  virtual bool factorize(const SparseMatrix& A, std::span<const char> held = {}, double lift = 0) = 0;

  /// Rough reciprocal condition number: squared ratio of the smallest to the largest diagonal entry of L. 0 without
  /// factor.
  virtual double rcond() const = 0;
  /// Of the last factorisation; after analyze() of one with nothing held.
  virtual FactorCost cost() const = 0;

  /// L^-1 P B and P^T L^-T B, both halves of a solve; rows between them stand in an order of the factor's own.
  /// Zero columns and right-hand sides with few entries are cheap in forward().
  /// @pre factorize() has succeeded
  virtual MatX forward(const MatX& B) const = 0;
  virtual MatX backward(const MatX& B) const = 0;
  MatX solve(const MatX& B) const { return backward(forward(B)); }
};

enum class CholeskyMethod {
  Multifrontal,  ///< default: ours, dense fronts [DUFF83] in panels, by vector kernels of the processor found
  Cholmod        ///< independent reference: CHOLMOD's supernodal factorisation [CHEN08]
};

enum class FrontKernelSet { Best, Generic, Avx2, Avx512 };

/// Those that this processor runs, Best apart; the fastest last.
std::vector<FrontKernelSet> available_front_kernels();
const char* to_string(FrontKernelSet kernels);

struct CholeskyOptions {
  CholeskyMethod method = CholeskyMethod::Multifrontal;
  // Of the multifrontal method:
  FrontKernelSet kernels = FrontKernelSet::Best;  ///< have to be available
  int threads = 1;                                ///< >= 1; any number gives the same bytes
};

std::unique_ptr<BlockCholesky> make_block_cholesky(const CholeskyOptions& options = {});

}  // namespace crease
