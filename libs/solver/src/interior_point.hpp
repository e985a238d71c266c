// SPDX-License-Identifier: MIT
#pragma once

#include "crease/solver/qp_solver.hpp"

namespace crease {

/// Our own interior point: predictor and corrector [MEHROTRA92] on the whole KKT system, one sparse factorisation an
/// iteration, no warm start. Finds a solution where there is one; tells neither that there is none nor that the
/// objective has no end: that is NumericalTrouble.
std::unique_ptr<QpSolver> make_interior_point_solver();

}  // namespace crease
