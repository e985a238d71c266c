// SPDX-License-Identifier: MIT
#include "multifrontal.hpp"

#include <algorithm>
#include <limits>
#include <new>
#include <numeric>

#include "block_graph.hpp"
#include "crease/base/require.hpp"
#include "ordering.hpp"

namespace crease {
namespace {

/// Time of a factorisation, in flops of the kernels, from which on it is worth waking threads: about a millisecond,
/// where waking one takes some 10 microseconds.
constexpr double least_shared = 4e7;

/// Places written at once in the list of borders: as many as most blocks have unknowns.
constexpr int spare = 4;

}  // namespace

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
  updates_.resize(1);
  worker_.assign(tree_.parent.size(), 0);
  fronts_.resize(tree_.parent.size());
  for (int s = 0; s < tree_.size(); ++s) fronts_[s].shape = tree_.shapes[s];
  place_fronts();
  if (n_threads_ > 1) share_out();
  return true;
} catch (const std::bad_alloc&) {
  return false;
}

void Multifrontal::collect_entries() {
  const int n_blocks = graph_.n_blocks();
  std::vector<int> sizes(static_cast<std::size_t>(n_blocks));
  for (int k = 0; k < n_blocks; ++k) sizes[k] = graph_.size(k);
  heights_.resize(sizes.size());
  entries_.resize(graph_.inner.size() + 1);
  entries_at_.assign(1, 0);
  const int* const inner = graph_.inner.data();  // what is written might be any of the class' numbers
  const int* const places = tree_.position.data();
  Entry* entry = entries_.data();
  for (int position = 0; position < n_blocks; ++position) {
    const int block = tree_.order[position], end = graph_.outer[block + 1];
    int offset = 0;
    for (int at = graph_.outer[block]; at < end; ++at) {
      const int other = inner[at], place = places[other];
      *entry = {place, offset};
      entry += place >= position;  // which looks random: no branch
      offset += sizes[other];
    }
    heights_[block] = offset;
    entries_at_.push_back(static_cast<int>(entry - entries_.data()));
  }
  values_at_.assign(1, 0);
  for (int k = 0; k < n_blocks; ++k) values_at_.push_back(values_at_[k] + heights_[k] * sizes[k]);
  int most_border = spare;
  for (const FrontShape& shape : tree_.shapes) most_border += shape.border;
  border_.resize(static_cast<std::size_t>(most_border));
  unknown_.resize(static_cast<std::size_t>(graph_.n_unknowns()));
  place_.resize(unknown_.size());
  free_at_.resize(sizes.size() + 1);
}

/// Sizes and places of all fronts with the held unknowns left out.
void Multifrontal::lay_out(std::span<const char> held) {
  int n_free = 0, n_held = 0;
  for (std::size_t position = 0; position < tree_.order.size(); ++position) {
    const int block = tree_.order[position];
    free_at_[position] = n_free;
    for (int i = graph_.starts[block]; i < graph_.starts[block + 1]; ++i)
      if (held.empty() || !held[i]) unknown_[n_free++] = i;
  }
  free_at_.back() = n_free;
  for (int i = 0; i < graph_.n_unknowns(); ++i)
    if (!held.empty() && held[i]) unknown_[n_free + n_held++] = i;
  for (std::size_t k = 0; k < unknown_.size(); ++k) place_[unknown_[k]] = static_cast<int>(k);
  int* border = border_.data();
  for (int s = 0; s < tree_.size(); ++s) {
    Front& front = fronts_[s];
    front.first = free_at_[tree_.first[s]];
    front.rows_at = static_cast<int>(border - border_.data());
    for (int at = tree_.rows_at[s]; at < tree_.rows_at[s + 1]; ++at) {
      const int first = free_at_[tree_.rows[at]], end = free_at_[tree_.rows[at] + 1];
      for (int i = first; i < end; i += spare)  // nearly always once: no branch on how many there are
        for (int k = 0; k < spare; ++k) border[i - first + k] = i + k;
      border += end - first;
    }
    front.shape = {free_at_[tree_.first[s + 1]] - front.first,
                   static_cast<int>(border - border_.data()) - front.rows_at};
  }
  place_fronts();
}

void Multifrontal::place_fronts() {
  cost_ = {};
  std::size_t factor_size = 0;
  most_border_panels_ = 0;
  for (Front& front : fronts_) {
    most_border_panels_ = std::max(most_border_panels_, front.shape.border_panels());
    front.factor_at = factor_size;
    factor_size += front.shape.factor_size();
    const double below = front.shape.border, all = below + front.shape.pivots;
    cost_.entries += (all * (all + 1) - below * (below + 1)) / 2;
    cost_.flops += (all * (all + 1) * (2 * all + 1) - below * (below + 1) * (2 * below + 1)) / 6;
  }
  factor_.reserve(factor_size);
  place_updates();
}

/// A node's update is done with once its parent is made, so each stack gives back what lies above the first child.
void Multifrontal::place_updates() {
  using Sizes = std::array<std::size_t, 2>;
  std::vector<Sizes> top(updates_.size(), Sizes{}), most(updates_.size(), Sizes{});
  for (int s = 0; s < tree_.size(); ++s) {
    const int worker = worker_[s], parity = depth_[s] % 2;
    fronts_[s].update_at = top[worker][parity];
    top[worker][parity] += fronts_[s].shape.update_size();
    most[worker][parity] = std::max(most[worker][parity], top[worker][parity]);
    int child = first_child_[s];
    while (child >= 0 && worker_[child] != worker) child = next_child_[child];  // others keep theirs to the end
    if (child >= 0) top[worker][1 - parity] = fronts_[child].update_at;
  }
  for (std::size_t worker = 0; worker < updates_.size(); ++worker)
    for (std::size_t parity : {0, 1}) updates_[worker][parity].reserve(most[worker][parity]);
}

/// By the sizes of the fronts with nothing held, so that it is done once an analysis.
void Multifrontal::share_out() {
  std::vector<double> time;
  for (const Front& front : fronts_) time.push_back(front_time(front.shape));
  if (std::accumulate(time.begin(), time.end(), 0.0) < least_shared) return;
  worker_ = share_subtrees(tree_.parent, time, n_threads_);
  updates_.resize(static_cast<std::size_t>(n_threads_) + 1);
  place_updates();
}

/// Fills fronts and factorises them. Where the unknowns of a front stand in it is kept in one table for all.
class Multifrontal::Assembly {
 public:
  /// Takes all memory that it will need, for an exception must not leave a thread.
  Assembly(const Multifrontal& owner, const double* values, double lift)
      : owner_(owner), values_(values), lift_(lift), border_index_(static_cast<std::size_t>(owner.n_free())) {
    child_rows_.resize(FrontShape::panel * static_cast<std::size_t>(owner.most_border_panels_));
    if (!owner.heights_.empty())
      rows_.reserve(static_cast<std::size_t>(*std::max_element(owner.heights_.begin(), owner.heights_.end())));
  }

  bool make_front(int s) {
    begin(owner_.fronts_[s]);
    std::fill(L_, L_ + front_->shape.factor_size(), 0.0);
    for (int position = owner_.tree_.first[s]; position < owner_.tree_.first[s + 1]; ++position) add_columns(position);
    for (int c = owner_.first_child_[s]; c >= 0; c = owner_.next_child_[c])
      add_child(c, owner_.kernels_.add_to_pivots, L_);
    // The update is written over by the product, so the children's shares of it come after.
    double* U = owner_.update_of(s);
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
    int n_pivots = 0;
    for (int i = 0; i < n; ++i) {
      child_rows_[i] = row_of(border[i]);
      n_pivots += is_pivot(border[i]);
    }
    add(front_->shape, n, n_pivots, child_rows_.data(), owner_.update_of(c), target);
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
  if (!factorize_fronts(A.valuePtr(), lift)) return false;
  factorized_ = true;
  find_rcond();
  return true;
}

/// Each front is computed in the same way whoever does it.
bool Multifrontal::factorize_fronts(const double* values, double lift) {
  std::vector<Assembly> assembly;
  assembly.reserve(updates_.size());
  for (std::size_t worker = 0; worker < updates_.size(); ++worker) assembly.emplace_back(*this, values, lift);
  std::vector<char> done(updates_.size(), 0);
  const auto work = [&](int worker) {
    for (int s = 0; s < tree_.size(); ++s)
      if (worker_[s] == worker && !assembly[worker].make_front(s)) return;
    done[worker] = 1;
  };
  const int last = static_cast<int>(updates_.size()) - 1;
  workers_.run(last, work);
  if (std::count(done.begin(), done.begin() + last, 0) > 0) return false;
  work(last);
  return done[last] != 0;
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
