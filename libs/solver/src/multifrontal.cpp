// SPDX-License-Identifier: MIT
#include "multifrontal.hpp"

#include <algorithm>
#include <limits>
#include <new>

#include "block_graph.hpp"
#include "crease/base/require.hpp"
#include "ordering.hpp"

namespace crease {

bool Multifrontal::analyze(const BlockGraph& graph, std::span<const int> order) try {
  require_valid(graph, order);
  factorized_ = false;
  rcond_ = 0;
  graph_ = graph;
  order_ = choose_order(graph, order);
  tree_ = make_supernode_tree(graph, order_);
  depth_.assign(tree_.parent.size(), 0);
  first_child_.assign(tree_.parent.size(), -1);
  next_child_.assign(tree_.parent.size(), -1);
  for (int s = tree_.size() - 1; s >= 0; --s)
    if (const int parent = tree_.parent[s]; parent >= 0) {
      depth_[s] = depth_[parent] + 1;
      next_child_[s] = first_child_[parent];
      first_child_[parent] = s;
    }
  collect_entries();
  lay_out({});
  return true;
} catch (const std::bad_alloc&) {
  return false;
}

void Multifrontal::collect_entries() {
  const int n_blocks = graph_.n_blocks();
  heights_.assign(static_cast<std::size_t>(n_blocks), 0);
  values_at_.assign(static_cast<std::size_t>(n_blocks) + 1, 0);
  for (int k = 0; k < n_blocks; ++k) {
    for (int at = graph_.outer[k]; at < graph_.outer[k + 1]; ++at) heights_[k] += graph_.size(graph_.inner[at]);
    values_at_[k + 1] = values_at_[k] + heights_[k] * graph_.size(k);
  }
  entries_.resize(graph_.inner.size() + 1);
  entries_at_.assign(1, 0);
  int n_entries = 0;
  for (int position = 0; position < n_blocks; ++position) {
    const int block = tree_.order[position];
    int offset = 0;
    for (int at = graph_.outer[block]; at < graph_.outer[block + 1]; ++at) {
      const int other = graph_.inner[at];
      entries_[n_entries] = {tree_.position[other], offset};
      n_entries += tree_.position[other] >= position;  // which looks random: no branch
      offset += graph_.size(other);
    }
    entries_at_.push_back(n_entries);
  }
}

/// Sizes and places of all fronts with the held unknowns left out.
void Multifrontal::lay_out(std::span<const char> held) {
  unknown_.clear();
  free_at_.clear();
  for (const int block : tree_.order) {
    free_at_.push_back(static_cast<int>(unknown_.size()));
    for (int i = graph_.starts[block]; i < graph_.starts[block + 1]; ++i)
      if (held.empty() || !held[i]) unknown_.push_back(i);
  }
  free_at_.push_back(static_cast<int>(unknown_.size()));
  for (int i = 0; i < graph_.n_unknowns(); ++i)
    if (!held.empty() && held[i]) unknown_.push_back(i);
  place_.resize(unknown_.size());
  for (std::size_t k = 0; k < unknown_.size(); ++k) place_[unknown_[k]] = static_cast<int>(k);
  fronts_.resize(tree_.parent.size());
  border_.clear();
  cost_ = {};
  std::size_t factor_size = 0, top[2] = {0, 0}, update_size[2] = {0, 0};
  most_border_panels_ = 0;
  for (int s = 0; s < tree_.size(); ++s) {
    Front& front = fronts_[s];
    front.first = free_at_[tree_.first[s]];
    front.rows_at = static_cast<int>(border_.size());
    for (int at = tree_.rows_at[s]; at < tree_.rows_at[s + 1]; ++at)
      for (int i = free_at_[tree_.rows[at]]; i < free_at_[tree_.rows[at] + 1]; ++i) border_.push_back(i);
    front.shape = {free_at_[tree_.first[s + 1]] - front.first, static_cast<int>(border_.size()) - front.rows_at};
    most_border_panels_ = std::max(most_border_panels_, front.shape.border_panels());
    front.factor_at = factor_size;
    factor_size += front.shape.factor_size();
    // The updates of its children lie on top of the other stack, where they are done with once this one is made.
    const int parity = depth_[s] % 2;
    front.update_at = top[parity];
    top[parity] += front.shape.update_size();
    update_size[parity] = std::max(update_size[parity], top[parity]);
    if (first_child_[s] >= 0) top[1 - parity] = fronts_[first_child_[s]].update_at;
    for (int k = 0; k < front.shape.pivots; ++k) {
      const double column = front.shape.pivots - k + front.shape.border;
      cost_.entries += column;
      cost_.flops += column * column;
    }
  }
  factor_.reserve(factor_size);
  for (int parity : {0, 1}) updates_[parity].reserve(update_size[parity]);
}

/// Fills fronts and factorises them. Where the unknowns of a front stand in it is kept in one table for all.
class Multifrontal::Assembly {
 public:
  Assembly(const Multifrontal& owner, const double* values, double lift)
      : owner_(owner), values_(values), lift_(lift), border_index_(static_cast<std::size_t>(owner.n_free())) {}

  bool make_front(int s) {
    begin(owner_.fronts_[s]);
    std::fill(L_, L_ + front_->shape.factor_size(), 0.0);
    for (int position = owner_.tree_.first[s]; position < owner_.tree_.first[s + 1]; ++position) add_columns(position);
    for (int c = owner_.first_child_[s]; c >= 0; c = owner_.next_child_[c])
      add_child(c, owner_.kernels_.add_to_pivots, L_);
    // The update is written over by the product, so the children's shares of it come after.
    double* U = update_of(s);
    if (!owner_.kernels_.factorize(front_->shape, L_, U)) return false;
    for (int c = owner_.first_child_[s]; c >= 0; c = owner_.next_child_[c])
      add_child(c, owner_.kernels_.add_to_update, U);
    return true;
  }

 private:
  struct Row {
    int target;            ///< place in a column of L
    std::ptrdiff_t value;  ///< in the first column of the block
  };

  double* update_of(int s) const { return owner_.updates_[owner_.depth_[s] % 2].data() + owner_.fronts_[s].update_at; }

  void begin(const Front& front) {
    front_ = &front;
    L_ = owner_.factor_.data() + front.factor_at;
    for (int i = 0; i < front.shape.border; ++i) border_index_[owner_.border_[front.rows_at + i]] = i;
  }

  bool is_pivot(int unknown) const { return unknown < front_->first + front_->shape.pivots; }

  int row_of(int unknown) const {
    return is_pivot(unknown) ? unknown - front_->first
                             : FrontShape::panel * front_->shape.column_panels() + border_index_[unknown];
  }
  /// Of a row of L, from the begin of a column.
  int row_place(int unknown) const {
    const int row = row_of(unknown);
    return (row >> 3) * static_cast<int>(front_->shape.row_panel_size()) + (row & 7);
  }

  /// The columns of A of the block at `position`. Rows of its own that lie above the diagonal come along: nobody reads
  /// them.
  void add_columns(int position) {
    const int block = owner_.tree_.order[position], start = owner_.graph_.starts[block];
    rows_.clear();
    for (int at = owner_.entries_at_[position]; at < owner_.entries_at_[position + 1]; ++at) {
      const Entry& entry = owner_.entries_[at];
      const int other_start = owner_.graph_.starts[owner_.tree_.order[entry.position]];
      for (int i = owner_.free_at_[entry.position]; i < owner_.free_at_[entry.position + 1]; ++i)
        rows_.push_back({row_place(i), owner_.values_at_[block] + entry.offset + owner_.unknown_[i] - other_start});
    }
    for (int j = owner_.free_at_[position]; j < owner_.free_at_[position + 1]; ++j) {
      const double* value = values_ + static_cast<std::ptrdiff_t>(owner_.unknown_[j] - start) * owner_.heights_[block];
      double* column = L_ + 8 * (j - front_->first);
      for (const Row& row : rows_) column[row.target] = value[row.value];
      column[row_place(j)] += lift_;
    }
  }

  /// @param add  one of the two kernels that add a child's update
  void add_child(int c, decltype(FrontKernels::add_to_pivots) add, double* target) {
    const Front& child = owner_.fronts_[c];
    const int* border = owner_.border_.data() + child.rows_at;
    const int n = child.shape.border;
    child_rows_.resize(static_cast<std::size_t>(n));
    int n_pivots = 0;
    for (int i = 0; i < n; ++i) {
      child_rows_[i] = row_of(border[i]);
      n_pivots += is_pivot(border[i]);
    }
    add(front_->shape, n, n_pivots, child_rows_.data(), update_of(c), target);
  }

  const Multifrontal& owner_;
  const double* values_;
  double lift_;
  const Front* front_ = nullptr;
  double* L_ = nullptr;
  std::vector<int> border_index_;  ///< one an unknown that lies in the border of the front at hand
  std::vector<Row> rows_;
  std::vector<int> child_rows_;
};

bool Multifrontal::factorize(const SparseMatrix& A, std::span<const char> held, double lift) {
  CREASE_ASSERT(A.nonZeros() == values_at_.back());
  factorized_ = false;
  rcond_ = 0;
  lay_out(held);
  Assembly assembly(*this, A.valuePtr(), lift);
  for (int s = 0; s < tree_.size(); ++s)
    if (!assembly.make_front(s)) return false;
  factorized_ = true;
  find_rcond();
  return true;
}

void Multifrontal::find_rcond() {
  const bool identity = n_free() < graph_.n_unknowns();  // its pivots count
  double smallest = identity ? 1 : std::numeric_limits<double>::infinity(), largest = identity ? 1 : 0;
  for (const Front& front : fronts_)
    for (int k = 0; k < front.shape.pivots; ++k) {
      const double* panel = factor_.data() + front.factor_at + (k >> 3) * front.shape.row_panel_size();
      const double reciprocal = panel[8 * k + (k & 7)];
      smallest = std::min(smallest, reciprocal);
      largest = std::max(largest, reciprocal);
    }
  const double ratio = largest > 0 ? smallest / largest : 1;
  rcond_ = ratio * ratio;
}

}  // namespace crease
