// SPDX-License-Identifier: MIT
#pragma once

#include "crease/solver/qp_solver.hpp"

namespace crease {

/// Interior point with exact derivatives, no warm start. Shares nothing with the active-set code, so the two check each
/// other.
std::unique_ptr<QpSolver> make_ipopt_solver();

}  // namespace crease
