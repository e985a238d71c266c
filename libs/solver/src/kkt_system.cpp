// SPDX-License-Identifier: MIT
#include "kkt_system.hpp"

#include <algorithm>
#include <cmath>

namespace crease {
namespace {

/// Scaled H (unit diagonal) with a smaller reciprocal condition than this is taken for singular: what is solved with it
/// is rounding.
constexpr double singular_rcond = 1e-14;
/// Softness of a row relative to the compliance it meets. Small against the angle squared of nearly dependent rows,
/// large against rounding in the border.
constexpr double row_softness = 1e-11;
/// Share of its compliance that the others have to leave to each row and coordinate of the border, if rows are to be
/// met without softness: far above rounding, the rest of which a refinement takes off.
constexpr double independent_share = 1e-8;
/// Coordinates whose state may differ from the factorised one before a new factorisation is the cheaper way, as a share
/// of the half-solves that have its flops. Half-solves are the slower kind of flop, and the border grows with the
/// square (measured on cloth-like problems of 1600 vertices: flat from 0.5 to 1.5).
constexpr double changed_share = 0.8;
constexpr int least_changed = 8;

}  // namespace

bool KktSystem::analyze(const BlockPattern& pattern) {
  if (analyzed_revision_ == pattern.revision()) return true;
  const bool done = cholesky_.analyze(pattern.graph(), {});
  analyzed_revision_ = done ? pattern.revision() : 0;
  return done;
}

void KktSystem::reset(const ReducedQp& qp, double epsilon) {
  qp_ = &qp;
  epsilon_ = epsilon;
  soft_ = false;
  delta_ = VecX::Zero(qp_->n_rows());
  factorized_ = false;
  border_set_ = {};
}

int KktSystem::n_changed(const WorkingSet& set) const {
  int changed = 0;
  for (size_t i = 0; i < base_.size(); ++i) changed += base_[i] != set.held[i];
  return changed;
}

bool KktSystem::refresh(const WorkingSet& set) {
  if (factorized_ && set.held == border_set_.held && set.on == border_set_.on) return true;
  border_set_ = {};
  const int most = std::max(least_changed, static_cast<int>(changed_share * cholesky_.cost().ratio()));
  const bool keep = factorized_ && n_changed(set) <= most && Y_.n_columns() <= 4 * most + qp_->n_rows();
  // A border that cannot be factorised may be the fault of the base it stands on, so the set gets a base of its own.
  bool ready = keep && add_columns(set) && factorize_border();
  if (!ready) ready = factorize(set) && add_columns(set) && factorize_border();
  if (!ready && factorized_ && soften()) ready = factorize_border();
  if (ready) border_set_ = set;
  return ready;
}

void KktSystem::give_softness() {
  soft_ = true;
  for (int w = 0; w < qp_->n_rows(); ++w)
    if (const int slot = slot_of_[qp_->size() + w]; slot >= 0 && delta_[w] == 0)
      delta_[w] = row_softness * std::max(1.0, gram_(slot, slot));
}

/// A row has its softness from the compliance it met when that was first wanted. Coordinates that have been let go
/// since may have left it so compliant that this is less than rounding. @return whether any row is softer now
bool KktSystem::soften() {
  bool softer = false;
  soft_ = true;
  for (const int item : tied_) {
    if (item < qp_->size()) continue;
    double& delta = delta_[item - qp_->size()];
    const double now = row_softness * gram_(slot_of_[item], slot_of_[item]);
    softer = softer || now > delta;
    delta = std::max(delta, now);
  }
  return softer;
}

/// Held coordinates become identity rows, which keeps the analysis.
bool KktSystem::factorize(const WorkingSet& set) {
  base_ = set.held;
  slot_of_.assign(static_cast<size_t>(qp_->size()) + static_cast<size_t>(qp_->n_rows()), -1);
  factorized_ = cholesky_.factorize(qp_->H, base_, epsilon_) && cholesky_.rcond() > singular_rcond;
  Y_.clear(cholesky_.n_free());
  return factorized_;
}

/// Collects the border of `set` and half-solves the columns it has not met since the last factorisation.
bool KktSystem::add_columns(const WorkingSet& set) {
  const int n = qp_->size();
  tied_.clear();
  freed_.clear();
  for (int i = 0; i < n; ++i)
    if (base_[i] != set.held[i]) (set.held[i] ? tied_ : freed_).push_back(i);
  for (int w = 0; w < qp_->n_rows(); ++w)
    if (set.on[w]) tied_.push_back(n + w);
  std::vector<int> fresh;
  for (const auto* items : {&tied_, &freed_})
    for (const int item : *items)
      if (slot_of_[item] < 0) fresh.push_back(item);
  if (fresh.empty()) return true;
  const int first = Y_.n_columns();
  cholesky_.forward(place_columns(fresh), Y_);
  const int n_new = Y_.n_columns() - first;
  if (gram_.rows() < Y_.n_columns()) gram_.conservativeResize(2 * Y_.n_columns(), 2 * Y_.n_columns());
  Y_.fill_gram(first, gram_);
  if (soft_) give_softness();
  return gram_.block(0, first, first + n_new, n_new).allFinite();
}

/// Gives the items their slots, in order of elimination, so that columns of one batch go through the same fronts.
SparseMatrix KktSystem::place_columns(const std::vector<int>& items) {
  struct Column {
    int first, item;
    Entries entries;
  };
  std::vector<Column> columns;
  Eigen::Index n_entries = 0;
  for (const int item : items) {
    columns.push_back({qp_->size(), item, column_of(item)});
    for (const auto& [row, value] : columns.back().entries)
      columns.back().first = std::min(columns.back().first, cholesky_.place(row));
    n_entries += static_cast<Eigen::Index>(columns.back().entries.size());
  }
  std::sort(columns.begin(), columns.end(),
            [](const Column& a, const Column& b) { return std::pair(a.first, a.item) < std::pair(b.first, b.item); });
  SparseMatrix C(qp_->size(), static_cast<Eigen::Index>(columns.size()));
  C.reserve(n_entries);
  for (int k = 0; k < static_cast<int>(columns.size()); ++k) {
    slot_of_[columns[k].item] = Y_.n_columns() + k;
    C.startVec(k);
    for (const auto& [row, value] : columns[k].entries) C.insertBack(row, k) = value;
  }
  C.finalize();
  return C;
}

/// The item's column of C: its coupling with the coordinates that were free when K was factorised.
KktSystem::Entries KktSystem::column_of(int item) const {
  const int n = qp_->size();
  Entries column;
  if (item >= n) {
    for (SparseRows::InnerIterator a(qp_->rows, item - n); a; ++a)
      if (!base_[a.col()]) column.emplace_back(static_cast<int>(a.col()), a.value());
  } else if (!base_[item]) {
    column.emplace_back(item, 1.0);
  } else {
    for (SparseMatrix::InnerIterator h(qp_->H, item); h; ++h)
      if (!base_[h.row()]) column.emplace_back(static_cast<int>(h.row()), h.value());
  }
  return column;
}

double KktSystem::at(int row, int column) const {
  const int* begin = qp_->H.innerIndexPtr() + qp_->H.outerIndexPtr()[column];
  const int* end = qp_->H.innerIndexPtr() + qp_->H.outerIndexPtr()[column + 1];
  const int* found = std::lower_bound(begin, end, row);
  if (found == end || *found != row) return 0;
  return qp_->H.valuePtr()[found - qp_->H.innerIndexPtr()] + (row == column ? epsilon_ : 0.0);
}

/// D between two items, `b` a freed coordinate.
double KktSystem::border_entry(int a, int b) const {
  const int n = qp_->size();
  if (a >= n) return qp_->rows.coeff(a - n, b);
  return base_[a] ? at(a, b) : 0.0;
}

/// T = [-N  B; B^T  S] with S > 0 (freed) and N > 0 (tied): S first, then N + B S^-1 B^T.
bool KktSystem::factorize_border() {
  const auto n_tied = static_cast<int>(tied_.size()), n_freed = static_cast<int>(freed_.size());
  const auto gram = [&](int a, int b) { return gram_(slot_of_[a], slot_of_[b]); };
  MatX S(n_freed, n_freed), N(n_tied, n_tied);
  coupling_.resize(n_tied, n_freed);
  for (int j = 0; j < n_freed; ++j) {
    for (int i = 0; i < n_freed; ++i) S(i, j) = border_entry(freed_[i], freed_[j]) - gram(freed_[i], freed_[j]);
    for (int i = 0; i < n_tied; ++i) coupling_(i, j) = border_entry(tied_[i], freed_[j]) - gram(tied_[i], freed_[j]);
  }
  for (int j = 0; j < n_tied; ++j)
    for (int i = 0; i < n_tied; ++i) N(i, j) = gram(tied_[i], tied_[j]);
  if (n_freed > 0) {
    freed_llt_.compute(S);
    if (freed_llt_.info() != Eigen::Success) return false;
    const double smallest = MatX(freed_llt_.matrixL()).diagonal().minCoeff();
    if (!(smallest * smallest > singular_rcond)) return false;
  }
  if (n_tied == 0) return true;
  if (n_freed > 0) {
    const MatX coupled = freed_llt_.matrixL().solve(coupling_.transpose());
    N.noalias() += coupled.transpose() * coupled;
  }
  if (!soft_ && tied_.back() >= qp_->size()) {
    tied_ldlt_.compute(N);
    if (are_independent(N)) return true;
    give_softness();
  }
  for (int i = 0; i < n_tied; ++i)
    if (tied_[i] >= qp_->size()) N(i, i) += delta_[tied_[i] - qp_->size()];
  tied_ldlt_.compute(N);
  return tied_ldlt_.info() == Eigen::Success && tied_ldlt_.vectorD().minCoeff() > 0;
}

/// By the pivots of N, each of which is what those before it have left of a compliance.
bool KktSystem::are_independent(const MatX& N) const {
  const VecX compliance = tied_ldlt_.transpositionsP() * N.diagonal();
  const VecX needed = independent_share * compliance.cwiseMax(1.0);
  return tied_ldlt_.info() == Eigen::Success && (tied_ldlt_.vectorD().array() >= needed.array()).all();
}

bool KktSystem::solve(const WorkingSet& set, const VecX& f, const VecX& value, const VecX& rhs, ReducedPoint& point) {
  if (!refresh(set)) return false;
  const int n = qp_->size();
  const auto n_tied = static_cast<int>(tied_.size()), n_freed = static_cast<int>(freed_.size());
  // What stays held moves to the right-hand side.
  VecX held = VecX::Zero(n);
  VecX push = f;
  for (int i = 0; i < n; ++i) {
    if (!base_[i] || !set.held[i] || value[i] == 0) continue;
    held[i] = value[i];
    for (SparseMatrix::InnerIterator h(qp_->H, i); h; ++h) push[h.row()] -= h.value() * value[i];
  }
  VecX r = push;
  for (int i = 0; i < n; ++i)
    if (base_[i]) r[i] = 0;
  // Of a correction after a change of the working set often nothing is left here: the border has it all.
  const bool pushed = (r.array() != 0).any();
  const VecX y = pushed ? VecX(cholesky_.forward(r)) : VecX::Zero(n);
  const VecX reached = pushed ? Y_.transposed_product(y) : VecX::Zero(Y_.n_columns());  // C^T K^-1 r
  const VecX row_held = qp_->rows * held;
  VecX s_tied(n_tied), s_freed(n_freed);
  for (int i = 0; i < n_tied; ++i) {
    const int item = tied_[i];
    s_tied[i] = (item < n ? value[item] : rhs[item - n] - row_held[item - n]) - reached[slot_of_[item]];
  }
  for (int i = 0; i < n_freed; ++i) s_freed[i] = push[freed_[i]] - reached[slot_of_[freed_[i]]];
  // z: minus the multipliers of tied items, displacements of freed ones.
  VecX z_tied(n_tied), z_freed(n_freed), z = VecX::Zero(Y_.n_columns());
  if (n_tied > 0) {
    VecX b = -s_tied;
    if (n_freed > 0) b += coupling_ * freed_llt_.solve(s_freed);
    z_tied = tied_ldlt_.solve(b);
  }
  if (n_freed > 0) {
    VecX b = s_freed;
    if (n_tied > 0) b -= coupling_.transpose() * z_tied;
    z_freed = freed_llt_.solve(b);
  }
  for (int i = 0; i < n_tied; ++i) z[slot_of_[tied_[i]]] = z_tied[i];
  for (int i = 0; i < n_freed; ++i) z[slot_of_[freed_[i]]] = z_freed[i];
  VecX x = y;
  Y_.subtract_product(z, x);
  point.u = cholesky_.backward(x);
  for (int i = 0; i < n; ++i)
    if (set.held[i]) point.u[i] = value[i];
  for (int i = 0; i < n_freed; ++i) point.u[freed_[i]] = z_freed[i];
  point.row_lambda = VecX::Zero(qp_->n_rows());
  for (int i = 0; i < n_tied; ++i)
    if (tied_[i] >= n) point.row_lambda[tied_[i] - n] = -z_tied[i];
  return point.u.allFinite() && point.row_lambda.allFinite();
}

}  // namespace crease
