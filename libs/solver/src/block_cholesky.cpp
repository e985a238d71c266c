// SPDX-License-Identifier: MIT
#include "crease/solver/block_cholesky.hpp"

#include <algorithm>

#include "block_graph.hpp"
#include "cholmod_cholesky.hpp"
#include "crease/base/require.hpp"
#include "find_kernels.hpp"
#include "multifrontal.hpp"

namespace crease {
namespace {

/// Whether the columns are ascending, hold their diagonal, and each entry has its mirror image: those above the
/// diagonal are met, in order, as the images of those below it in earlier columns.
bool is_symmetric_graph(const BlockGraph& graph) {
  const int n = graph.n_blocks();
  const int* const inner = graph.inner.data();
  const int* const outer = graph.outer.data();
  std::vector<int> next(outer, outer + n);  // entry of each column that is to be met next
  for (int c = 0; c < n; ++c) {
    if (next[c] >= outer[c + 1] || inner[next[c]] != c) return false;
    for (int at = next[c] + 1, former = c; at < outer[c + 1]; ++at) {
      const int row = inner[at];
      if (row <= former || row >= n || next[row] >= outer[row + 1] || inner[next[row]++] != c) return false;
      former = row;
    }
  }
  return true;
}

}  // namespace

void require_valid(const BlockGraph& graph, std::span<const int> order) {
  const auto& [starts, outer, inner] = graph;
  require(!starts.empty() && starts.front() == 0 &&
              std::adjacent_find(starts.begin(), starts.end(), std::greater_equal<>()) == starts.end(),
          "BlockCholesky: expected strictly ascending starts of blocks from 0");
  require(outer.size() == starts.size() && outer.front() == 0 && outer.back() == static_cast<int>(inner.size()) &&
              std::is_sorted(outer.begin(), outer.end()),
          "BlockCholesky: expected one column of the graph a block");
  require(is_symmetric_graph(graph), "BlockCholesky: expected ascending columns with diagonal, in both triangles");
  if (order.empty()) return;
  std::vector<char> met(starts.size() - 1, 0);
  bool permutation = order.size() == met.size();
  for (const int block : order) {
    permutation = permutation && block >= 0 && block < graph.n_blocks() && !met[block];
    if (permutation) met[block] = 1;
  }
  require(permutation, "BlockCholesky: expected an order with each block once");
}

SparseMatrix make_block_matrix(const BlockGraph& graph) {
  const int n = graph.n_unknowns();
  SparseMatrix A(n, n);
  int* outer = A.outerIndexPtr();
  outer[0] = 0;
  for (int block = 0; block < graph.n_blocks(); ++block) {
    int height = 0;
    for (int at = graph.outer[block]; at < graph.outer[block + 1]; ++at) height += graph.size(graph.inner[at]);
    for (int c = graph.starts[block]; c < graph.starts[block + 1]; ++c) outer[c + 1] = outer[c] + height;
  }
  A.resizeNonZeros(outer[n]);
  int* row = A.innerIndexPtr();
  for (int block = 0; block < graph.n_blocks(); ++block)
    for (int c = graph.starts[block]; c < graph.starts[block + 1]; ++c)
      for (int at = graph.outer[block]; at < graph.outer[block + 1]; ++at)
        for (int r = graph.starts[graph.inner[at]]; r < graph.starts[graph.inner[at] + 1]; ++r) *row++ = r;
  std::fill(A.valuePtr(), A.valuePtr() + outer[n], 0.0);
  return A;
}

std::unique_ptr<BlockCholesky> make_block_cholesky(const CholeskyOptions& options) {
  require(options.threads >= 1,
          "make_block_cholesky: expected at least one thread, got " + std::to_string(options.threads));
  switch (options.method) {
    case CholeskyMethod::Multifrontal:
      return std::make_unique<Multifrontal>(find_front_kernels(options.kernels), options.threads);
    case CholeskyMethod::Cholmod:
      return std::make_unique<CholmodCholesky>();
  }
  require(false, "make_block_cholesky: unknown method");
  return nullptr;
}

}  // namespace crease
