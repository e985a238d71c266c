// SPDX-License-Identifier: MIT
#pragma once

#include "crease/solver/qp.hpp"

namespace crease {

/// Farkas: multipliers y with A^T y = 0, y_in >= 0 and b^T y > 0 exclude every q with A_eq q = b_eq, A_in q >= b_in.
/// In rounding A^T y is not quite zero, which leaves room for a q of size b^T y / |A^T y|_1; `ray` counts as a proof if
/// that is out of all proportion to `q`.
bool proves_infeasible(const QpProblem& problem, const VecX& ray_eq, VecX ray_in, const VecX& q);

/// A direction d with H d = 0, A_eq d = 0, A_in d >= 0 and f^T d > 0, along which the objective falls without end.
bool proves_unbounded(const QpProblem& problem, const VecX& ray);

}  // namespace crease
