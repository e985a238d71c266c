// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "crease/solver/block_cholesky.hpp"
#include "front_kernels.hpp"

namespace crease {

/// Symbolic factorisation of a graph of blocks: supernodes (sets of columns of L with nearly the same rows below them),
/// as a forest in which a supernode updates its ancestors alone. Supernodes are numbered children first, every subtree
/// in one piece.
struct SupernodeTree {
  std::vector<int> order;     ///< block eliminated at each position; may differ from the given order within its tree
  std::vector<int> position;  ///< its inverse
  std::vector<int> first;     ///< first position of each supernode; last entry the number of blocks
  std::vector<int> parent;    ///< -1 = root
  std::vector<int> rows_at, rows;  ///< positions of the blocks below the columns of each supernode, ascending
  std::vector<FrontShape> shapes;  ///< of their fronts, with nothing held

  int size() const { return static_cast<int>(parent.size()); }
};

SupernodeTree make_supernode_tree(const BlockGraph& graph, std::span<const int> order);

/// Time that one front takes, in flops of the kernels.
double front_time(FrontShape shape);

/// Shares subtrees out to `n_parts` workers so that the slowest, and what is left at the top for afterwards, take the
/// least time.
/// @param parent  -1 = root; children before their parents
/// @return        one a node: its worker, or `n_parts` for what is left
std::vector<int> share_subtrees(const std::vector<int>& parent, const std::vector<double>& time, int n_parts);

}  // namespace crease
