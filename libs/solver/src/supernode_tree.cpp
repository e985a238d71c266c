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

/// One analysis. Columns are positions in the order given until the supernodes are numbered.
class Analysis {
 public:
  Analysis(const BlockGraph& graph, std::span<const int> order)
      : graph_(graph), order_(order.begin(), order.end()), position_(inverse(order_)) {}

  SupernodeTree run() {
    find_columns();
    form_supernodes();
    merge_supernodes();
    number_supernodes();
    find_rows();
    return std::move(tree_);
  }

 private:
  /// Rows below the diagonal of each column of L: those of A, and those of the columns of which it is the first row
  /// (its children).                                                                                      [LIU90]
  void find_columns() {
    const std::size_t n = order_.size();
    std::vector<int> first_child(n, -1), next_child(n, -1), children;
    columns_.resize(n);
    parent_.assign(n, -1);
    continues_.assign(n, -1);
    seen_by_.assign(n, -1);
    for (int k = 0; k < static_cast<int>(n); ++k) {
      children.clear();
      for (int c = first_child[k]; c >= 0; c = next_child[c]) children.push_back(c);
      if (children.size() != 1 || children[0] != k - 1 || !take_over(k)) collect(k, children);
      int first = static_cast<int>(n);
      for (const int row : rows_of(k)) first = std::min(first, row);
      if (columns_[k].size == 0) continue;
      parent_[k] = first;
      next_child[k] = first_child[first];
      first_child[first] = k;
    }
  }

  /// Which rows are new looks random, so no branch is taken on it.
  void collect(int k, const std::vector<int>& children) {
    const std::span in_A = blocks_beside(order_[k]);
    std::size_t most = in_A.size();
    for (const int c : children) most += columns_[c].size;
    const std::size_t end = k > 0 ? columns_[k - 1].at + columns_[k - 1].size : 0;
    if (rows_.size() < end + most + 1) rows_.resize(2 * (end + most + 1));
    int* const rows = rows_.data() + end;
    int size = 0;
    const auto add = [k, rows, &size, seen = seen_by_.data()](int row) {
      rows[size] = row;
      size += (row > k) & (seen[row] != k);
      seen[row] = k;
    };
    for (const int block : in_A) add(position_[block]);
    for (const int c : children)
      for (const int row : rows_of(c)) add(row);
    for (const int c : children)
      if (columns_[c].size == size + 1) continues_[k] = c;
    columns_[k] = {end, size};
    stamp_ = k;
  }

  /// Where k - 1 is the only child of k and has all rows that A has at k, which is the most frequent case.
  bool take_over(int k) {
    int n_new = 0;
    for (const int block : blocks_beside(order_[k]))
      n_new += (position_[block] > k) & (seen_by_[position_[block]] != stamp_);
    if (n_new > 0) return false;
    columns_[k] = {columns_[k - 1].at, columns_[k - 1].size - 1};
    int* const rows = rows_.data() + columns_[k].at;
    *std::find(rows, rows + columns_[k].size, k) = rows[columns_[k].size];
    continues_[k] = k - 1;
    return true;
  }

  /// Chains of columns of which each has the rows of the next, and that one itself. Numbered by their last columns, so
  /// children before their parents.
  void form_supernodes() {
    const int n = static_cast<int>(order_.size());
    std::vector<char> is_last(order_.size(), 1);
    std::vector<int> sizes(order_.size()), pivots(order_.size());  // the latter up to each column of its chain
    for (int k = 0; k < n; ++k) {
      pivots[k] = sizes[k] = graph_.size(order_[k]);
      if (const int c = continues_[k]; c >= 0) pivots[k] += pivots[c], is_last[c] = 0;
    }
    node_of_.resize(order_.size());
    nodes_.reserve(order_.size());
    for (int k = 0; k < n; ++k)
      if (is_last[k]) {
        node_of_[k] = static_cast<int>(nodes_.size());
        nodes_.push_back({k, {pivots[k], 0}, 0});
      }
    for (int k = n - 1; k >= 0; --k)
      if (const int c = continues_[k]; c >= 0) node_of_[c] = node_of_[k];
    for (Node& node : nodes_) {
      int border = 0;
      for (const int row : rows_of(node.last)) border += sizes[row];
      node.shape.border = border;
      node.time = front_time(node.shape);
      node_parent_.push_back(parent_[node.last] < 0 ? -1 : node_of_[parent_[node.last]]);
    }
  }

  /// A child joins its parent where one larger front takes less time than two. Its columns then count with the rows of
  /// the parent, which contain its own.
  void merge_supernodes() {
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
      tree_.rows_at.push_back(tree_.rows_at.back() + columns_[nodes_[s].last].size);
      for (const int row : rows_of(nodes_[s].last)) ++at[now_[row] + 1];
    }
    std::partial_sum(at.begin(), at.end(), at.begin());
    std::vector<int> next(at.begin(), at.end() - 1), having(static_cast<std::size_t>(at.back()));
    for (int s = 0; s < tree_.size(); ++s)
      for (const int row : rows_of(nodes_[last_nodes_[s]].last)) having[next[now_[row]]++] = s;
    tree_.rows.resize(having.size());
    std::vector<int> filled(tree_.rows_at.begin(), tree_.rows_at.end() - 1);
    for (int row = 0; row < static_cast<int>(order_.size()); ++row)
      for (int k = at[row]; k < at[row + 1]; ++k) tree_.rows[filled[having[k]]++] = row;
  }

  struct Column {
    std::size_t at;  ///< in rows_
    int size;
  };
  struct Node {
    int last;  ///< column
    FrontShape shape;
    double time;
  };

  std::span<const int> blocks_beside(int block) const {
    return std::span(graph_.inner).subspan(graph_.outer[block], graph_.outer[block + 1] - graph_.outer[block]);
  }
  std::span<const int> rows_of(int column) const {
    return std::span(rows_).subspan(columns_[column].at, static_cast<std::size_t>(columns_[column].size));
  }

  const BlockGraph& graph_;
  std::vector<int> order_, position_;
  std::vector<int> rows_;
  std::vector<Column> columns_;
  std::vector<int> seen_by_;
  int stamp_ = -1;
  std::vector<int> parent_,
      continues_;  ///< one a column, -1 = none; the other is the child whose chain it goes on with
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
