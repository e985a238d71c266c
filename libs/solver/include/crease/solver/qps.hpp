// SPDX-License-Identifier: MIT
#pragma once

#include <iosfwd>
#include <string_view>

#include "crease/solver/qp.hpp"

namespace crease {

/// Programs as files that other solvers read: QPS [MAROS99] with free format, that is MPS whose words are separated by
/// spaces, and a section QUADOBJ for one triangle of H.
///
/// A line for each number, in the shortest digits that tell it exactly: what is read back has the same bits. Unknowns
/// are x0, x1, .., free; rows e0, .. (equal) and i0, .. (at least); the objective's row is -f. What QPS has no place
/// for, `blocks`, stands in lines "* blocks START .." that others take for comments.
///
/// Throws std::invalid_argument on a malformed problem (require_valid).
void write_qps(std::ostream& out, const QpProblem& problem, std::string_view name);

/// Reads QPS of any origin: rows N, E, G and L; one or two entries a line; bounds LO, UP, FX, FR, MI and PL, each of
/// which becomes a row behind the others, as does 0 <= x where no bound is told; QUADOBJ (one triangle) or QMATRIX
/// (both). An L row and an upper bound change sign. A constant in the objective is left out. Throws std::runtime_error
/// that names the line where something is wrong or not supported (ranges, integers).
QpProblem read_qps(std::istream& in);

}  // namespace crease
