// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Cholesky>
#include <utility>
#include <vector>

#include "find_kernels.hpp"
#include "multifrontal.hpp"
#include "reduction.hpp"

namespace crease {

/// The equations of one working set of a ReducedQp,
///   (H + epsilon I) u - rows^T lambda = f   on the coordinates not held,
///   u = value                               on those held,
///   rows u + delta lambda = rhs             on the rows that are on,
/// solved from one sparse factorisation of H with the held coordinates masked (identity rows, so the pattern and its
/// analysis stay). Rows, and coordinates whose state has changed since that factorisation, form a dense border:
///   [ K  C ] [u]   [r]     K  masked H,  C = one column a border item,
///   [ C' D ] [z] = [s]     T = D - C' K^-1 C  from forward half-solves Y = L^-1 C, kept until the next factorisation.
/// Rows are met as they are, delta = 0, until some turn out to depend on one another: from then on delta > 0 keeps T
/// regular, and the caller removes its effect by iterating.
class KktSystem {
 public:
  explicit KktSystem(int threads) : cholesky_(kernels(), threads), Y_(kernels()) {}
  /// Does nothing if `pattern` is the one analysed last. @return false if the analysis failed
  bool analyze(const BlockPattern& pattern);
  /// Call whenever a value has changed; `qp` has to stay until the next call.
  void reset(const ReducedQp& qp, double epsilon);

  /// Held coordinates whose value is zero cost nothing.
  /// @return false if the matrix of this working set is singular to working precision
  bool solve(const WorkingSet& set, const VecX& f, const VecX& value, const VecX& rhs, ReducedPoint& point);

  double epsilon() const { return epsilon_; }
  /// Softness of a row; 0 for one that has never been on.
  double delta(int row) const { return delta_[row]; }
  /// Whether rows have softness since the last reset().
  bool is_soft() const { return soft_; }

 private:
  static const FrontKernels& kernels() { return find_front_kernels(FrontKernelSet::Best); }
  bool refresh(const WorkingSet& set);
  bool factorize(const WorkingSet& set);
  bool add_columns(const WorkingSet& set);
  bool factorize_border();
  bool are_independent(const MatX& N) const;
  void give_softness();
  bool soften();
  int n_changed(const WorkingSet& set) const;
  using Entries = std::vector<std::pair<int, double>>;
  Entries column_of(int item) const;
  SparseMatrix place_columns(const std::vector<int>& items);
  double border_entry(int item_a, int item_b) const;
  double at(int row, int column) const;

  const ReducedQp* qp_ = nullptr;
  double epsilon_ = 0;
  bool soft_ = false;
  VecX delta_;
  Multifrontal cholesky_;
  bool factorized_ = false;
  int analyzed_revision_ = 0;
  std::vector<char> base_;  ///< held at the last factorisation

  // Border items are numbered like unknowns: coordinate i, then n + row.
  std::vector<int> slot_of_;  ///< an item's column of Y_, -1 = none yet
  HalfSolves Y_;
  MatX gram_;               ///< Y^T Y
  WorkingSet border_set_;   ///< the set the border below belongs to
  std::vector<int> tied_;   ///< items with a multiplier: newly held coordinates and rows
  std::vector<int> freed_;  ///< items with a displacement
  MatX coupling_;           ///< T between tied and freed
  Eigen::LLT<MatX> freed_llt_;
  Eigen::LDLT<MatX> tied_ldlt_;
};

}  // namespace crease
