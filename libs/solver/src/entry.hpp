// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include "crease/solver/qp.hpp"

namespace crease {

class BlockPattern;

/// What is seen of H by the way.
struct Checked {
  double largest;     ///< size of an entry
  bool same_pattern;  ///< as `former`
};

/// Everything a backend is called with; throws std::invalid_argument.
/// @param former  of a problem that was valid: where the pattern of H is the same it is not gone through again
Checked require_valid(const QpProblem& problem, const QpOptions& options, std::span<const char> guess,
                      const BlockPattern* former = nullptr);

/// The answer if it takes no search: nothing pulls and q = 0 is allowed (relative tolerances would have no scale to
/// hold on to), or there are no unknowns.
std::optional<QpResult> solve_at_rest(const QpProblem& problem);

}  // namespace crease
