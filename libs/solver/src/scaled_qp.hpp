// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "crease/solver/qp.hpp"

namespace crease {

/// A problem in q = size * scale .* y with a unit diagonal of H, unit rows and numbers about 1, as the absolute
/// tolerances of interior points like it:
///
///   minimise 1/2 y^T H y - f^T y   subject to   (A y = b)_i for i < n_eq,   (A y >= b)_i for the others.
///
/// Stationarity: H y - f = A^T lambda.
struct ScaledQp {
  SparseMatrix H;
  VecX f;
  SparseRows A;
  VecX b;
  int n_eq = 0;
  VecX scale, row_norm;
  double size = 1;
  std::vector<int> eq;    ///< equalities kept: the largest independent set, which an interior point cannot do without
  bool conflict = false;  ///< one of the others contradicts them

  explicit ScaledQp(const QpProblem& problem);

  /// The answer where the equalities contradict each other.
  std::optional<QpResult> refusal() const;

  /// What y and lambda say of the problem, or the corner that they point at, if that is as good: an interior point is
  /// only near the solution. The status is left to the caller.
  QpResult read_out(const QpProblem& problem, const VecX& y, const VecX& lambda) const;
};

}  // namespace crease
