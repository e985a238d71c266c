// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "crease/solver/qp.hpp"

namespace crease {

/// H q = f: what a step solves where there is nothing to constrain. One factorisation and refinement; the
/// symbolic analysis is kept while the pattern of H stays.
class LinearSolver {
 public:
  /// @param threads  of the factorisation, >= 1; any number gives the same bytes
  explicit LinearSolver(int threads = 1);
  ~LinearSolver();
  LinearSolver(LinearSolver&&) noexcept;

  /// Solved, or NumericalTrouble if H is not positive definite to working precision; `iterations` stays 0.
  /// Throws std::invalid_argument on a malformed problem or one with constraints.
  QpResult solve(const QpProblem& problem, const QpOptions& options = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace crease
