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

/// One analysis; every array is over positions until the supernodes are formed.
class Analysis {
 public:
  Analysis(const BlockGraph& graph, std::span<const int> order) : graph_(graph) {
    tree_.order.assign(order.begin(), order.end());
    tree_.position = inverse(tree_.order);
  }

  SupernodeTree run() {
    list_earlier();
    find_elimination_tree();
    relabel(postorder(parent_));
    count_rows();
    form_supernodes();
    merge_supernodes();
    number_supernodes();
    find_rows();
    return std::move(tree_);
  }

 private:
  /// The positions before each that touch it. Which entries those are looks random, so no branch is taken on it.
  void list_earlier() {
    earlier_at_.assign(1, 0);
    earlier_.resize(graph_.inner.size() + 1);
    int n_listed = 0;
    for (int k = 0; k < static_cast<int>(tree_.order.size()); ++k) {
      const int block = tree_.order[k];
      for (int at = graph_.outer[block]; at < graph_.outer[block + 1]; ++at) {
        const int other = tree_.position[graph_.inner[at]];
        earlier_[n_listed] = other;
        n_listed += other < k;
      }
      earlier_at_.push_back(n_listed);
    }
    earlier_.resize(static_cast<std::size_t>(n_listed));
  }

  /// The positions after each that touch it, ascending.
  struct Later {
    std::vector<int> at, positions;

    explicit Later(const Analysis& analysis) : at(analysis.earlier_at_.size(), 0), positions(analysis.earlier_.size()) {
      for (const int k : analysis.earlier_) ++at[k + 1];
      std::partial_sum(at.begin(), at.end(), at.begin());
      std::vector<int> next(at.begin(), at.end() - 1);
      for (int row = 0; row + 1 < static_cast<int>(at.size()); ++row)
        for (const int k : analysis.earlier(row)) positions[next[k]++] = row;
    }
    std::span<const int> of(int k) const { return std::span(positions).subspan(at[k], at[k + 1] - at[k]); }
  };

  std::span<const int> earlier(int k) const {
    return std::span(earlier_).subspan(static_cast<std::size_t>(earlier_at_[k]),
                                       static_cast<std::size_t>(earlier_at_[k + 1] - earlier_at_[k]));
  }

  /// parent = first later row in the column of L, by ever shorter paths to the root so far [LIU90].
  void find_elimination_tree() {
    const std::size_t n = tree_.order.size();
    parent_.assign(n, -1);
    std::vector<int> ancestor(n, -1);
    for (int k = 0; k < static_cast<int>(n); ++k)
      for (int j : earlier(k)) {
        while (ancestor[j] >= 0 && ancestor[j] != k) j = std::exchange(ancestor[j], k);
        if (ancestor[j] < 0) ancestor[j] = parent_[j] = k;
      }
  }

  /// Renames positions: the one that was `former[k]` becomes k.
  void relabel(const std::vector<int>& former) {
    const std::vector<int> now = inverse(former);
    std::vector<int> order, parent, earlier_at{0}, earlier;
    earlier.reserve(earlier_.size());
    for (const int k : former) {
      order.push_back(tree_.order[k]);
      parent.push_back(parent_[k] < 0 ? -1 : now[parent_[k]]);
      for (const int j : this->earlier(k)) earlier.push_back(now[j]);
      earlier_at.push_back(static_cast<int>(earlier.size()));
    }
    tree_.order = std::move(order);
    tree_.position = inverse(tree_.order);
    parent_ = std::move(parent);
    earlier_ = std::move(earlier);
    earlier_at_ = std::move(earlier_at);
  }

  /// Row i of L is the subtree that climbs from its entries in A up to i. It is the sum of the paths from its leaves,
  /// less what they share: each path is added at its leaf, and taken off where it meets that of the leaf before (the
  /// first one at i), as a step of the counts along the tree.                                         [GILBERT94]
  void count_rows() {
    const int n = static_cast<int>(tree_.order.size());
    std::vector<int> first(tree_.order.size()), ancestor(tree_.order.size());  // least descendant; towards the root
    std::iota(first.begin(), first.end(), 0);
    std::iota(ancestor.begin(), ancestor.end(), 0);
    for (int k = 0; k < n; ++k)
      if (const int p = parent_[k]; p >= 0) first[p] = std::min(first[p], first[k]);
    n_rows_.assign(tree_.order.size(), 0);
    n_blocks_.assign(tree_.order.size(), 0);
    const auto add = [&](int k, int row, int sign) {
      n_rows_[k] += sign * graph_.size(tree_.order[row]);
      n_blocks_[k] += sign;
    };
    const auto root = [&](int k) {
      while (ancestor[k] != k) k = ancestor[k] = ancestor[ancestor[k]];
      return k;
    };
    std::vector<int> covered(tree_.order.size(), -1), leaf(tree_.order.size(), -1);  // by the last leaf of each row
    const Later later(*this);
    for (int k = 0; k < n; ++k) {
      for (const int row : later.of(k)) {
        if (first[k] <= covered[row]) continue;  // an entry before stands below it
        covered[row] = first[k];
        const int former = std::exchange(leaf[row], k);
        add(k, row, 1);
        add(former < 0 ? row : root(former), row, -1);
      }
      if (parent_[k] >= 0) ancestor[k] = parent_[k];
    }
    for (int k = 0; k < n; ++k)
      if (const int p = parent_[k]; p >= 0) n_rows_[p] += n_rows_[k], n_blocks_[p] += n_blocks_[k];
  }

  /// Chains of columns of which each has the rows of the next, and that one itself.
  void form_supernodes() {
    const int n = static_cast<int>(tree_.order.size());
    std::vector<int> node_of(tree_.order.size());
    for (int k = 0; k < n; ++k) {
      const bool continues = k > 0 && parent_[k - 1] == k && n_blocks_[k - 1] == n_blocks_[k] + 1;
      if (!continues) nodes_.push_back({k, k, 0, 0, 0});
      nodes_.back().last = k;
      nodes_.back().pivots += graph_.size(tree_.order[k]);
      node_of[k] = static_cast<int>(nodes_.size()) - 1;
    }
    node_parent_.resize(nodes_.size());
    for (std::size_t s = 0; s < nodes_.size(); ++s) {
      Node& node = nodes_[s];
      node.border = n_rows_[node.last];
      node.border_blocks = n_blocks_[node.last];
      node_parent_[s] = parent_[node.last] < 0 ? -1 : node_of[parent_[node.last]];
    }
  }

  /// A child joins its parent where one larger front takes less time than two. Its columns then count with the rows of
  /// the parent, which contain its own.
  void merge_supernodes() {
    Children children(node_parent_);
    merged_into_.resize(nodes_.size());
    std::iota(merged_into_.begin(), merged_into_.end(), 0);
    for (int p = 0; p < static_cast<int>(nodes_.size()); ++p) {
      Node& parent = nodes_[p];
      std::vector<int> waiting;
      for (int c = children.first[p]; c >= 0; c = children.next[c]) waiting.push_back(c);
      while (!waiting.empty()) {
        const int c = waiting.back();
        waiting.pop_back();
        const Node& child = nodes_[c];
        const double apart = front_time({child.pivots, child.border}) + front_time({parent.pivots, parent.border});
        if (front_time({child.pivots + parent.pivots, parent.border}) >= apart) continue;
        parent.pivots += child.pivots;
        merged_into_[c] = p;
      }
    }
  }

  /// Final positions: a supernode's own columns after all of its subtree.
  void number_supernodes() {
    const auto n_nodes = static_cast<int>(nodes_.size());
    for (int s = n_nodes - 1; s >= 0; --s) merged_into_[s] = merged_into_[merged_into_[s]];
    std::vector<int> kept, kept_number(nodes_.size(), -1), kept_parent;
    for (int s = 0; s < n_nodes; ++s)
      if (merged_into_[s] == s) kept_number[s] = static_cast<int>(kept.size()), kept.push_back(s);
    for (const int s : kept)
      kept_parent.push_back(node_parent_[s] < 0 ? -1 : kept_number[merged_into_[node_parent_[s]]]);
    const std::vector<int> former = postorder(kept_parent);
    const std::vector<int> now = inverse(former);
    std::vector<std::vector<int>> members(kept.size());
    for (int s = 0; s < n_nodes; ++s) members[now[kept_number[merged_into_[s]]]].push_back(s);
    std::vector<int> positions;
    positions.reserve(tree_.order.size());
    tree_.rows_at.assign(1, 0);
    for (std::size_t s = 0; s < kept.size(); ++s) {
      const int top = kept[former[s]];
      tree_.first.push_back(static_cast<int>(positions.size()));
      tree_.parent.push_back(kept_parent[former[s]] < 0 ? -1 : now[kept_parent[former[s]]]);
      tree_.rows_at.push_back(tree_.rows_at.back() + nodes_[top].border_blocks);
      for (const int member : members[s])
        for (int k = nodes_[member].first; k <= nodes_[member].last; ++k) positions.push_back(k);
    }
    tree_.first.push_back(static_cast<int>(positions.size()));
    relabel(positions);
  }

  /// The climb of count_rows() once more, by supernodes; rows come in ascending order by themselves.
  void find_rows() {
    tree_.rows.resize(static_cast<std::size_t>(tree_.rows_at.back()));
    std::vector<int> filled(tree_.rows_at.begin(), tree_.rows_at.end() - 1), seen_by(tree_.parent.size(), -1),
        node_of(tree_.order.size());
    for (int s = 0; s < tree_.size(); ++s)
      for (int k = tree_.first[s]; k < tree_.first[s + 1]; ++k) node_of[k] = s;
    for (int i = 0; i < static_cast<int>(tree_.order.size()); ++i) {
      seen_by[node_of[i]] = i;
      for (const int j : earlier(i))
        for (int s = node_of[j]; seen_by[s] != i; s = tree_.parent[s]) {
          seen_by[s] = i;
          tree_.rows[filled[s]++] = i;
        }
    }
  }

  struct Node {
    int first, last;    ///< positions
    int pivots;         ///< unknowns
    int border;         ///< unknowns below
    int border_blocks;  ///< blocks below
  };

  const BlockGraph& graph_;
  SupernodeTree tree_;
  std::vector<int> earlier_at_, earlier_;
  std::vector<int> parent_, n_rows_, n_blocks_;
  std::vector<Node> nodes_;
  std::vector<int> node_parent_, merged_into_;
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
