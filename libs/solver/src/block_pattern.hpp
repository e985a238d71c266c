// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "crease/solver/block_cholesky.hpp"
#include "crease/solver/qp.hpp"

namespace crease {

/// H x of a symmetric matrix of make_block_matrix(graph).
VecX multiply(const BlockGraph& graph, const SparseMatrix& H, const VecX& x);

/// The sparsity of H rounded up to whole blocks, so that a change of basis inside the blocks does not alter it.
/// The values of one block column then lie in memory as one dense column-major matrix, `height` x block size.
class BlockPattern {
 public:
  /// Whether pattern of H and blocks of `problem` are those of the last update().
  bool is_that_of(const QpProblem& problem) const;
  /// Follows the pattern of H and the blocks of `problem`. @return whether anything changed since the last call
  bool update(const QpProblem& problem);

  /// Counts the changes, so that an analysis can tell whether it is of this pattern.
  int revision() const { return revision_; }

  /// Both triangles, ascending; the matrices here are those of make_block_matrix().
  const BlockGraph& graph() const { return graph_; }
  int n_blocks() const { return graph_.n_blocks(); }
  int start(int block) const { return graph_.starts[block]; }
  int size(int block) const { return graph_.size(block); }
  int block_of(int unknown) const { return block_of_[unknown]; }
  int height(int block) const { return heights_[block]; }

  /// Whether H stores every entry of its blocks already.
  bool is_full() const { return is_full_; }
  /// Largest |H_ij - H_ji|. @pre is_full(), and H is of this pattern
  double asymmetry(const SparseMatrix& H) const;
  /// The values of H, in the order of make_block_matrix().
  void gather(const SparseMatrix& H, double* values) const;

 private:
  void set_blocks(const QpProblem& problem);
  void build_graph(const SparseMatrix& H);
  void find_mirrors();

  std::vector<int> given_blocks_, given_outer_, given_inner_;  ///< what update() compares with
  BlockGraph graph_;
  std::vector<int> block_of_, heights_;
  std::vector<int> mirrors_;  ///< first values of the mirror images of the blocks below the diagonal, column by column
  int revision_ = 0;
  bool is_full_ = false;
};

}  // namespace crease
