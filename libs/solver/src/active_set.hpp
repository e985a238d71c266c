// SPDX-License-Identifier: MIT
#pragma once

#include "crease/solver/qp_solver.hpp"
#include "kkt_system.hpp"
#include "working_set_search.hpp"

namespace crease {

/// Primal-dual active set (block principal pivoting) with a dual active-set method behind it.    [KIM-PARK11] [GI83]
///
/// 1. Local rows become bounds by a change of basis in their block (Reduction).
/// 2. Search for the working set whose solution has no wrong sign (WorkingSetSearch).
/// 3. Where rows are soft (delta) or H is lifted (epsilon), repeat from the point found until neither shows: the
///    proximal method of multipliers. Its steps settle on a ray if the problem has no solution, which certifies
///    infeasibility (a ray of multipliers) or unboundedness (a ray of points).                   [ROCKAFELLAR76]
/// 4. No answer leaves without its kkt_residual() on the problem as given.
class ActiveSetSolver : public QpSolver {
 public:
  explicit ActiveSetSolver(int threads) : kkt_(threads) {}
  QpResult solve(const QpProblem& problem, const QpOptions& options, std::span<const char> guess) override;

 private:
  enum class Attempt { Decided, Inexact, Singular, BudgetSpent };
  /// Solves with H lifted by `epsilon` on its scaled diagonal. `result` is the best point found unless it is Singular.
  Attempt attempt(const QpProblem& problem, const QpOptions& options, std::span<const char> guess, double epsilon,
                  QpResult& result);
  /// Asks the reference solver; where that fails too, `best` stands if it has a point.
  static QpResult fall_back(const QpProblem& problem, const QpOptions& options, std::span<const char> guess,
                            QpResult best);
  QpResult read_out(const QpProblem& problem, const WorkingSet& set, const ReducedPoint& point,
                    const VecX& gradient) const;

  Reduction reduction_;
  KktSystem kkt_;
};

}  // namespace crease
