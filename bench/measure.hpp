// SPDX-License-Identifier: MIT
#pragma once

// What the benchmarks share: the clock, and a matrix's graph of blocks.

#include <algorithm>
#include <ctime>
#include <vector>

#include "crease/solver/block_cholesky.hpp"

namespace crease {

inline double seconds_of(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// @pre H stores every entry of its blocks
inline BlockGraph graph_of(const SparseMatrix& H, const std::vector<int>& starts) {
  BlockGraph graph;
  graph.starts = starts;
  std::vector<int> block_of(static_cast<std::size_t>(H.rows()));
  for (int k = 0; k < graph.n_blocks(); ++k)
    std::fill(block_of.begin() + starts[k], block_of.begin() + starts[k + 1], k);
  for (int k = 0; k < graph.n_blocks(); ++k) {
    for (SparseMatrix::InnerIterator entry(H, starts[k]); entry; ++entry)
      if (const int other = block_of[entry.row()];
          static_cast<int>(graph.inner.size()) == graph.outer.back() || graph.inner.back() != other)
        graph.inner.push_back(other);
    graph.outer.push_back(static_cast<int>(graph.inner.size()));
  }
  return graph;
}

}  // namespace crease
