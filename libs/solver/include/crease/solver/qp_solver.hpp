// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>

#include "crease/solver/qp.hpp"

namespace crease {

enum class QpMethod {
  ActiveSet,      ///< default: primal-dual active set on one Cholesky factorisation, local rows as bounds, general rows
                  ///< in a Schur border
  InteriorPoint,  ///< what answers where the active set gives up; knows nothing of blocks and has no warm start
  Ipopt           ///< independent reference: interior point, exact Hessian
};

/// Keeps a factorisation's symbolic analysis and workspace between calls.
class QpSolver {
 public:
  virtual ~QpSolver() = default;
  /// @param guess  optional start: 1 = inequality expected active; empty = all local ones active
  /// Never throws on numerics: every outcome is a status. Throws std::invalid_argument on a malformed problem.
  virtual QpResult solve(const QpProblem& problem, const QpOptions& options = {}, std::span<const char> guess = {}) = 0;
};

/// @param threads  of the factorisation, >= 1; any number gives the same bytes. The reference runs on one.
std::unique_ptr<QpSolver> make_qp_solver(QpMethod method, int threads = 1);

}  // namespace crease
