// SPDX-License-Identifier: MIT
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "crease/solver/block_cholesky.hpp"
#include "support/qp_problems.hpp"

/// Graphs of blocks and positive definite matrices on them.
namespace crease::support {

/// @param size  of block k
template <class Size>
BlockGraph make_graph(int n_blocks, const std::vector<std::pair<int, int>>& edges, const Size& size) {
  std::vector<std::set<int>> touched(static_cast<std::size_t>(n_blocks));
  for (int k = 0; k < n_blocks; ++k) touched[k].insert(k);
  for (const auto& [a, b] : edges) touched[a].insert(b), touched[b].insert(a);
  BlockGraph graph;
  for (int k = 0; k < n_blocks; ++k) {
    graph.starts.push_back(graph.starts.back() + size(k));
    graph.inner.insert(graph.inner.end(), touched[k].begin(), touched[k].end());
    graph.outer.push_back(static_cast<int>(graph.inner.size()));
  }
  return graph;
}

inline int three(int) {
  return 3;
}
/// Cloth with a crease: a few vertices have 5 unknowns.
inline int three_or_five(int k) {
  return k % 7 == 3 ? 5 : 3;
}

inline BlockGraph path_graph(int n) {
  std::vector<std::pair<int, int>> edges;
  for (int k = 1; k < n; ++k) edges.emplace_back(k - 1, k);
  return make_graph(n, edges, three);
}

inline BlockGraph star_graph(int n, int hub) {
  std::vector<std::pair<int, int>> edges;
  for (int k = 0; k < n; ++k) edges.emplace_back(k, hub);
  return make_graph(n, edges, three_or_five);
}

/// Vertices of a grid, each touching the eight around it.
inline BlockGraph grid_graph(int columns, int rows) {
  std::vector<std::pair<int, int>> edges;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      for (const auto& [di, dj] : {std::pair(1, 0), {-1, 1}, {0, 1}, {1, 1}})
        if (i + di >= 0 && i + di < columns && j + dj < rows)
          edges.emplace_back(j * columns + i, (j + dj) * columns + i + di);
  return make_graph(columns * rows, edges, three_or_five);
}

inline BlockGraph random_graph(int n, int n_edges, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::pair<int, int>> edges;
  for (int e = 0; e < n_edges; ++e) edges.emplace_back(random.integer(0, n - 1), random.integer(0, n - 1));
  std::vector<int> sizes;
  for (int k = 0; k < n; ++k) sizes.push_back(random.integer(1, 8));
  return make_graph(n, edges, [&](int k) { return sizes[k]; });
}

inline std::vector<std::pair<std::string, BlockGraph>> block_graphs() {
  return {{"empty", {}},
          {"one unknown", make_graph(1, {}, [](int) { return 1; })},
          {"one vertex", make_graph(1, {}, three)},
          {"one large block", make_graph(1, {}, [](int) { return 45; })},
          {"no edges", make_graph(20, {}, three_or_five)},
          {"path", path_graph(30)},
          {"star", star_graph(25, 12)},
          {"grid", grid_graph(11, 9)},
          {"strip", grid_graph(60, 2)},
          {"complete", random_graph(15, 2000, 1)},
          {"random, connected", random_graph(60, 240, 2)},
          {"random, in pieces", random_graph(80, 60, 3)},
          {"scalars", make_graph(40, {{0, 5}, {5, 9}, {9, 0}, {12, 13}, {30, 39}, {39, 5}}, [](int) { return 1; })}};
}

struct BlockMatrix {
  BlockGraph graph;
  SparseMatrix A;
};

/// Random entries with a diagonal that outweighs them: the condition number is below 1e3.
inline BlockMatrix random_spd(Random& random, const BlockGraph& graph) {
  BlockMatrix matrix{graph, make_block_matrix(graph)};
  const int n = graph.n_unknowns();
  VecX weight = VecX::Zero(n);
  for (int c = 0; c < n; ++c)
    for (SparseMatrix::InnerIterator entry(matrix.A, c); entry; ++entry) {
      if (entry.row() <= c) continue;
      const double value = random.uniform(-1, 1);
      entry.valueRef() = value;
      matrix.A.coeffRef(c, entry.row()) = value;
      weight[c] += std::abs(value);
      weight[entry.row()] += std::abs(value);
    }
  for (int i = 0; i < n; ++i) matrix.A.coeffRef(i, i) = weight[i] + random.uniform(0.1, 1);
  return matrix;
}

/// What the elimination of the blocks in this order takes, by eliminating them one after the other.
inline FactorCost filled_cost(const BlockGraph& graph, const std::vector<int>& order) {
  std::vector<std::set<int>> touched(static_cast<std::size_t>(graph.n_blocks()));
  for (int k = 0; k < graph.n_blocks(); ++k)
    touched[k].insert(graph.inner.begin() + graph.outer[k], graph.inner.begin() + graph.outer[k + 1]);
  FactorCost cost;
  for (const int k : order) {
    double height = 0;
    for (const int other : touched[k]) height += graph.size(other);
    for (int i = 0; i < graph.size(k); ++i, --height) cost.entries += height, cost.flops += height * height;
    for (const int a : touched[k])
      for (const int b : touched[k])
        if (a != k && b != k) touched[a].insert(b);
    for (const int other : std::set<int>(touched[k])) touched[other].erase(k);
  }
  return cost;
}

}  // namespace crease::support
