// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "kkt_system.hpp"

namespace crease {

/// Where the proximal terms are anchored: epsilon/2 |u - u0|^2 and the rows' softness delta (lambda - lambda0).
using Anchor = ReducedPoint;

enum class SearchStatus { Optimal, Singular, IterationLimit };

/// Finds the working set whose solution u, lambda of
///   (H + epsilon) u - rows^T lambda = f + epsilon u0,   rows u + delta (lambda - lambda0) >= rhs,   u >= bound
/// has no wrong sign. Strictly convex in u and lambda for epsilon, delta > 0, so there is just one answer.
class WorkingSetSearch {
 public:
  WorkingSetSearch(const ReducedQp& qp, KktSystem& kkt, int max_iterations);

  /// Starts from `set` and leaves there the set found.
  SearchStatus run(const Anchor& anchor, WorkingSet& set, ReducedPoint& point);

  int iterations() const { return iterations_; }
  /// H u - f - rows^T lambda.
  VecX gradient(const ReducedPoint& point) const;

 private:
  /// Constraints are numbered like unknowns: coordinate i, then n + row. A negative slack or multiplier is wrong.
  struct Signs {
    VecX slack, lambda;
    VecX least_slack, least_lambda;  ///< below these a value is wrong, above a tie
  };

  SearchStatus exchange_blocks(WorkingSet& set, ReducedPoint& point);
  SearchStatus ascend_dual(WorkingSet& set, ReducedPoint& point);
  SearchStatus make_dual_feasible(WorkingSet& set, ReducedPoint& point);
  SearchStatus admit(int item, const VecX& start_lambda, WorkingSet& set, ReducedPoint& point);
  bool solve(const WorkingSet& set, ReducedPoint& point);
  void refine(const WorkingSet& set, ReducedPoint& point);
  Signs signs(const ReducedPoint& point) const;
  std::vector<int> wrong(const WorkingSet& set, const Signs& signs) const;
  bool is_inequality(int item) const;
  char& state(WorkingSet& set, int item) const;

  const ReducedQp& qp_;
  KktSystem& kkt_;
  Anchor anchor_;
  int max_iterations_, iterations_ = 0, single_iterations_ = 0;
};

}  // namespace crease
