// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "crease/solver/qp.hpp"

namespace crease {

/// The sparsity of H rounded up to whole blocks, so that a change of basis inside the blocks does not alter it.
/// The values of one block column then lie in memory as one dense column-major matrix, `height` x block size.
class BlockPattern {
 public:
  /// Follows the pattern of H and the blocks of `problem`. @return whether anything changed since the last call
  bool update(const QpProblem& problem);

  /// Counts the changes, so that an analysis can tell whether it is of this pattern.
  int revision() const { return revision_; }

  int n_blocks() const { return static_cast<int>(starts_.size()) - 1; }
  int start(int block) const { return starts_[block]; }
  int size(int block) const { return starts_[block + 1] - starts_[block]; }
  int block_of(int unknown) const { return block_of_[unknown]; }
  int height(int block) const { return heights_[block]; }
  const std::vector<int>& starts() const { return starts_; }

  /// Compressed columns of the block graph, both triangles, ascending.
  std::vector<int>& outer() { return outer_; }
  std::vector<int>& inner() { return inner_; }

  /// A matrix of this pattern, all zero.
  SparseMatrix make_matrix() const;
  /// The values of H, in the order of make_matrix().
  void gather(const SparseMatrix& H, double* values) const;

 private:
  void set_blocks(const QpProblem& problem);
  void build_graph(const SparseMatrix& H);

  std::vector<int> given_blocks_, given_outer_, given_inner_;  ///< what update() compares with
  std::vector<int> starts_, block_of_, outer_, inner_, heights_;
  int revision_ = 0;
  bool is_full_ = false;  ///< H stores every entry of its blocks already
};

}  // namespace crease
