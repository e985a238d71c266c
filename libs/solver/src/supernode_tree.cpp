// SPDX-License-Identifier: MIT
#include "supernode_tree.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace crease {
namespace {

/// Time of one front in flops of the kernels (about 40 to the nanosecond): what it takes to begin one, to clear and
/// fill an entry of L, and to add an entry of its update to its parent. Measured on fronts of 10 to 100 rows.
constexpr double flops_a_front = 10000;
constexpr double flops_an_entry = 12;
constexpr double flops_an_update = 20;

std::vector<int> inverse(const std::vector<int>& order) {
  std::vector<int> position(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) position[order[k]] = static_cast<int>(k);
  return position;
}

/// Forest over positions or supernodes: children in ascending order as linked lists.
struct Children {
  std::vector<int> first, next;
  explicit Children(const std::vector<int>& parent) : first(parent.size() + 1, -1), next(parent.size(), -1) {
    for (int k = static_cast<int>(parent.size()) - 1; k >= 0; --k) {
      const std::size_t p = parent[k] < 0 ? parent.size() : static_cast<std::size_t>(parent[k]);
      next[k] = first[p];
      first[p] = k;
    }
  }
};

std::vector<int> postorder(const std::vector<int>& parent) {
  Children children(parent);
  std::vector<int> order, stack;
  order.reserve(parent.size());
  for (int root = children.first.back(); root >= 0; root = children.next[root]) {
    stack.push_back(root);
    while (!stack.empty()) {
      const int node = stack.back(), child = children.first[node];
      if (child >= 0) {
        children.first[node] = children.next[child];
        stack.push_back(child);
      } else {
        order.push_back(node);
        stack.pop_back();
      }
    }
  }
  return order;
}

struct Rows {
  std::size_t at, size;
};

/// Columns of L from `first` to `end`, each of which has the rows of the next, and that one itself. Numbered children
/// before their parents.
struct Node {
  int first, end;
  int parent;  ///< first row, or the number of columns
  Rows rows;   ///< of the last one
  FrontShape shape;
  double time;
};

/// One analysis. Columns are positions in the order given until the supernodes are numbered.
class Analysis {
 public:
  Analysis(const BlockGraph& graph, std::span<const int> order)
      : graph_(graph), order_(order.begin(), order.end()), position_(inverse(order_)) {}

  SupernodeTree run() {
    find_nodes();
    find_shapes();
    merge_nodes();
    number_supernodes();
    find_rows();
    return std::move(tree_);
  }

 private:
  /// Rows below the diagonal of a column of L: those of A, and those of the columns of which it is the first row (its
  /// children) [LIU90]. As long as the next column has all its own among them, and no other child, the two share a
  /// node.
  void find_nodes() {
    const auto n = static_cast<int>(order_.size());
    std::vector<int> first_child(order_.size(), -1), next_child;  // nodes: one a column, one a node
    node_of_.resize(order_.size());
    seen_by_.assign(order_.size(), -1);
    nodes_.reserve(order_.size());
    next_child.reserve(order_.size());
    for (int k = 0, end = 0; k < n; k = end) {
      const auto s = static_cast<int>(nodes_.size());
      Node node{k, k + 1, n, collect(k, first_child[k], next_child), {}, 0};
      while (node.end < n && first_child[node.end] < 0 && has_rows_of(node.end, k)) ++node.end;
      end = node.end;
      if (end > k + 1) drop_below(end, node.rows);
      std::fill(node_of_.begin() + k, node_of_.begin() + end, s);
      if (end < n && seen_by_[end] == k)
        node.parent = end;  // mostly so
      else
        for (const int row : rows_of(node)) node.parent = std::min(node.parent, row);
      next_child.push_back(-1);
      if (node.parent < n) next_child[s] = std::exchange(first_child[node.parent], s);
      nodes_.push_back(node);
    }
  }

  /// The rows of column k. Which of them are new looks random, so no branch is taken on it.
  Rows collect(int k, int first_child, const std::vector<int>& next_child) {
    const std::span in_A = blocks_beside(k);
    std::size_t most = in_A.size();
    for (int c = first_child; c >= 0; c = next_child[c]) most += nodes_[c].rows.size;
    const std::size_t begin = nodes_.empty() ? 0 : nodes_.back().rows.at + nodes_.back().rows.size;
    if (rows_.size() < begin + most + 1) rows_.resize(2 * (begin + most + 1));
    int* const rows = rows_.data() + begin;
    int* const seen = seen_by_.data();
    std::size_t size = 0;
    seen[k] = k;
    for (const int block : in_A) {
      const int row = rows[size] = position_[block];
      size += (row > k) & (seen[row] != k);
      seen[row] = k;
    }
    for (int c = first_child; c >= 0; c = next_child[c])
      for (const int row : rows_of(nodes_[c])) {
        rows[size] = row;
        size += seen[row] != k;
        seen[row] = k;
      }
    return {begin, size};
  }

  /// Whether `column` is one of the rows collected last, which are those of k, and A has no row there that is not.
  bool has_rows_of(int column, int k) const {
    if (seen_by_[column] != k) return false;
    int n_new = 0;
    for (const int block : blocks_beside(column)) {
      const int row = position_[block];
      n_new += (row > column) & (seen_by_[row] != k);
    }
    return n_new == 0;
  }

  void drop_below(int end, Rows& kept) {
    int* const rows = rows_.data() + kept.at;
    std::size_t size = 0;
    for (std::size_t i = 0; i < kept.size; ++i) {
      const int row = rows[size] = rows[i];
      size += row >= end;
    }
    kept.size = size;
  }

  void find_shapes() {
    std::vector<int> sizes(order_.size());
    for (std::size_t k = 0; k < sizes.size(); ++k) sizes[k] = graph_.size(order_[k]);
    for (Node& node : nodes_) {
      for (int k = node.first; k < node.end; ++k) node.shape.pivots += sizes[k];
      for (const int row : rows_of(node)) node.shape.border += sizes[row];
      node.time = front_time(node.shape);
      node_parent_.push_back(node.parent < static_cast<int>(sizes.size()) ? node_of_[node.parent] : -1);
    }
  }

  /// A child joins its parent where one larger front takes less time than two. Its columns then count with the rows of
  /// the parent, which contain its own.
  void merge_nodes() {
    Children children(node_parent_);
    merged_into_.resize(nodes_.size());
    std::iota(merged_into_.begin(), merged_into_.end(), 0);
    std::vector<int> waiting;
    for (int p = 0; p < static_cast<int>(nodes_.size()); ++p) {
      Node& parent = nodes_[p];
      for (int c = children.first[p]; c >= 0; c = children.next[c]) waiting.push_back(c);
      for (; !waiting.empty(); waiting.pop_back()) {
        const int c = waiting.back();
        const FrontShape both{nodes_[c].shape.pivots + parent.shape.pivots, parent.shape.border};
        const double together = front_time(both);
        if (together >= nodes_[c].time + parent.time) continue;
        parent.shape = both;
        parent.time = together;
        merged_into_[c] = p;
      }
    }
  }

  /// Final positions: a supernode's own columns after all of its subtree.
  void number_supernodes() {
    const auto n_nodes = static_cast<int>(nodes_.size());
    std::vector<int> kept, number(nodes_.size()), kept_parent;
    for (int s = 0; s < n_nodes; ++s)
      if (merged_into_[s] == s) number[s] = static_cast<int>(kept.size()), kept.push_back(s);
    for (int s = n_nodes - 1; s >= 0; --s) number[s] = number[merged_into_[s]];
    for (const int s : kept) kept_parent.push_back(node_parent_[s] < 0 ? -1 : number[node_parent_[s]]);
    const std::vector<int> former = postorder(kept_parent);
    const std::vector<int> now = inverse(former);
    for (int& k : number) k = now[k];
    for (const int s : former) {
      last_nodes_.push_back(kept[s]);
      tree_.shapes.push_back(nodes_[kept[s]].shape);
      tree_.parent.push_back(kept_parent[s] < 0 ? -1 : now[kept_parent[s]]);
    }
    tree_.first.assign(kept.size() + 1, 0);
    for (const int node : node_of_) ++tree_.first[number[node] + 1];
    std::partial_sum(tree_.first.begin(), tree_.first.end(), tree_.first.begin());
    std::vector<int> next(tree_.first.begin(), tree_.first.end() - 1);
    tree_.order.resize(order_.size());
    tree_.position.resize(order_.size());
    now_.resize(order_.size());
    for (std::size_t k = 0; k < order_.size(); ++k) {
      const int position = now_[k] = next[number[node_of_[k]]]++;
      tree_.order[position] = order_[k];
      tree_.position[order_[k]] = position;
    }
  }

  /// Of the last column of each supernode. They are sorted by going through the positions: each into the lists of all
  /// that have it.
  void find_rows() {
    tree_.rows_at.assign(1, 0);
    std::vector<int> at(order_.size() + 1, 0);
    for (const int s : last_nodes_) {
      tree_.rows_at.push_back(tree_.rows_at.back() + static_cast<int>(nodes_[s].rows.size));
      for (const int row : rows_of(nodes_[s])) ++at[now_[row] + 1];
    }
    std::partial_sum(at.begin(), at.end(), at.begin());
    std::vector<int> next(at.begin(), at.end() - 1), having(static_cast<std::size_t>(at.back()));
    for (int s = 0; s < tree_.size(); ++s)
      for (const int row : rows_of(nodes_[last_nodes_[s]])) having[next[now_[row]]++] = s;
    tree_.rows.resize(having.size());
    std::vector<int> filled(tree_.rows_at.begin(), tree_.rows_at.end() - 1);
    for (int row = 0; row < static_cast<int>(order_.size()); ++row)
      for (int k = at[row]; k < at[row + 1]; ++k) tree_.rows[filled[having[k]]++] = row;
  }

  std::span<const int> blocks_beside(int column) const {
    const int block = order_[column];
    return std::span(graph_.inner).subspan(graph_.outer[block], graph_.outer[block + 1] - graph_.outer[block]);
  }
  std::span<const int> rows_of(const Node& node) const {
    return std::span(rows_).subspan(node.rows.at, node.rows.size);
  }

  const BlockGraph& graph_;
  std::vector<int> order_, position_;
  std::vector<int> rows_;
  std::vector<int> seen_by_;
  std::vector<Node> nodes_;
  std::vector<int> node_of_, node_parent_, merged_into_;
  std::vector<int> last_nodes_;  ///< the uppermost node of each supernode
  std::vector<int> now_;         ///< final position of each column
  SupernodeTree tree_;
};

}  // namespace

double front_time(FrontShape shape) {
  const double p = FrontShape::panel * shape.column_panels(), b = FrontShape::panel * shape.border_panels();
  const double product_flops = shape.pivots * (b * b / 2 + p * b / 2 + p * p / 6) * 2;
  return flops_a_front + flops_an_entry * p * (p + b) + flops_an_update * b * b / 2 + product_flops;
}

SupernodeTree make_supernode_tree(const BlockGraph& graph, std::span<const int> order) {
  return Analysis(graph, order).run();
}

}  // namespace crease
