// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include "crease/solver/qp.hpp"

namespace crease {

/// Everything a backend is called with; throws std::invalid_argument.
void require_valid(const QpProblem& problem, const QpOptions& options, std::span<const char> guess);

/// The answer if it takes no search: nothing pulls and q = 0 is allowed (relative tolerances would have no scale to
/// hold on to), or there are no unknowns.
std::optional<QpResult> solve_at_rest(const QpProblem& problem);

}  // namespace crease
