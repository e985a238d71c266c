// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "block_basis.hpp"
#include "block_pattern.hpp"
#include "entry.hpp"

namespace crease {

enum class Coordinate : char { Free, Bounded, Fixed };

/// The problem in coordinates u in which every local constraint is a bound:
///   minimise 1/2 u^T H u - f^T u   s.t.  u_i = bound_i (Fixed),  u_i >= bound_i (Bounded),  rows u = | >= rhs.
/// Coordinates are scaled to a unit diagonal of H and rows to unit length, so tolerances are plain numbers.
struct ReducedQp {
  SparseMatrix H;                     ///< both triangles, pattern of whole blocks
  const BlockGraph* graph = nullptr;  ///< of those
  VecX f;
  std::vector<Coordinate> kind;
  VecX bound;
  SparseRows rows;  ///< equalities first
  VecX rhs;
  int n_equalities = 0;
  VecX unit;  ///< one a coordinate, then one a row: its change per unit change of the original unknowns

  int size() const { return static_cast<int>(f.size()); }
  int n_rows() const { return static_cast<int>(rhs.size()); }
};

/// Which bounds and rows are taken as equations.
struct WorkingSet {
  std::vector<char> held;  ///< one a coordinate; Fixed ones always
  std::vector<char> on;    ///< one a row; equalities always
};

/// A point of the reduced problem.
struct ReducedPoint {
  VecX u, row_lambda;
};

struct Multipliers {
  VecX eq, in;
};

/// The change of variables between QpProblem and ReducedQp: q = T u block by block.
class Reduction {
 public:
  /// @return false if constraints of a single block contradict each other; reduced() is then not usable
  bool build(const QpProblem& problem, const Checked& checked);
  const ReducedQp& reduced() const { return qp_; }
  const BlockPattern& pattern() const { return pattern_; }

  /// @param guess  one an inequality of the problem, or empty: all local ones
  WorkingSet start(std::span<const char> guess) const;
  std::vector<char> active(const WorkingSet& set) const;
  VecX to_q(const VecX& u) const;
  /// @param gradient  H u - f - rows^T row_lambda; the multiplier of a held coordinate
  Multipliers to_multipliers(const VecX& gradient, const VecX& row_lambda, const WorkingSet& set) const;

 private:
  struct GeneralRow {
    int row;
    bool equality;
    double norm;  ///< of the row in u before scaling; set by add_general_rows()
    double size;  ///< of the row in q
  };

  struct TransformedRow {
    std::vector<std::pair<int, double>> entries;
    double all = 0, open = 0;                ///< squared length, and of its part outside the fixed coordinates
    double fixed_value = 0, fixed_size = 0;  ///< sum, and sum of sizes, of the terms of the fixed coordinates
  };

  void sort_rows(const SparseRows& A, const VecX& b, bool equality);
  bool make_bases();
  void transform_H(const SparseMatrix& H);
  void set_scale(int block, const SmallMatrix& diagonal_block);
  TransformedRow transform_row(const SparseRows& A, int row) const;
  bool add_general_rows(const QpProblem& problem);

  BlockPattern pattern_;
  ReducedQp qp_;
  double largest_ = 0;  ///< entry of H
  double q_scale_ = 0;
  int n_in_ = 0, n_eq_ = 0;
  std::vector<std::vector<LocalRow>> local_eq_, local_in_;  ///< one a block
  std::vector<GeneralRow> general_;
  std::vector<int> basis_of_;  ///< one a block; -1 = T is diagonal
  std::vector<BlockBasis> bases_;
  std::vector<int> basis_block_;
  VecX scale_;                               ///< one a coordinate: sqrt of H's diagonal
  std::vector<int> coordinate_of_, row_of_;  ///< one an inequality; -1 = none
};

}  // namespace crease
