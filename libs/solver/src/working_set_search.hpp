// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "kkt_system.hpp"

namespace crease {

enum class SearchStatus { Optimal, Singular, IterationLimit };

/// Finds the working set whose solution u, lambda of
///   (H + epsilon) u - rows^T lambda = f + epsilon u0,   rows u + delta (lambda - lambda0) >= rhs,   u >= bound
/// has no wrong sign, where u0 and lambda0 (the anchor) are those at which the search begins. Strictly convex in u and
/// lambda for epsilon, delta > 0, so there is just one answer.
///
/// Every solve is for a correction of the point at hand, so each also takes off what rounding left by those before.
class WorkingSetSearch {
 public:
  WorkingSetSearch(const ReducedQp& qp, KktSystem& kkt, int max_iterations);

  enum class Precision {
    Plain,   ///< as the last solve leaves it
    Refined  ///< corrected down to rounding
  };
  /// Starts from `set` and leaves there the set found; from where the last run ended, the first one from zero.
  SearchStatus run(Precision precision, WorkingSet& set);

  /// What the last run did to the multipliers of the rows.
  VecX way() const { return point_.row_lambda - anchor_.row_lambda; }
  /// Goes on that way, `times` as far again, before the next run.
  void go_on(double times);

  int iterations() const { return iterations_; }
  /// Where the last run ended.
  const ReducedPoint& point() const { return point_; }
  /// H u - f - rows^T lambda there.
  const VecX& gradient() const { return gradient_; }

 private:
  /// Constraints are numbered like unknowns: coordinate i, then n + row. A negative slack or multiplier is wrong.
  struct Signs {
    VecX slack, lambda;
    VecX least_slack, least_lambda;  ///< below these a value is wrong, above a tie
  };

  /// What a point misses of the equations of a working set.
  struct Rest {
    VecX force, rows;
  };

  SearchStatus exchange_blocks(WorkingSet& set);
  SearchStatus ascend_dual(WorkingSet& set);
  SearchStatus make_dual_feasible(WorkingSet& set);
  SearchStatus admit(int item, const VecX& start_lambda, WorkingSet& set);
  bool solve(const WorkingSet& set);
  bool refine(const WorkingSet& set);
  Rest rest(const WorkingSet& set) const;
  double force_rounding() const;  ///< below it a force is rounding of the sums it comes from
  bool is_rounding(const Rest& rest) const;
  void update_gradient();
  Signs signs() const;
  std::vector<int> wrong(const WorkingSet& set, const Signs& signs) const;
  bool is_inequality(int item) const;
  char& state(WorkingSet& set, int item) const;

  const ReducedQp& qp_;
  KktSystem& kkt_;
  ReducedPoint anchor_;
  Precision precision_ = Precision::Refined;
  ReducedPoint point_;
  VecX gradient_;
  int max_iterations_, iterations_ = 0, single_iterations_ = 0;
};

}  // namespace crease
