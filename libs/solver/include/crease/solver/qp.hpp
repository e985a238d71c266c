// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "crease/base/types.hpp"

namespace crease {

/// minimise 1/2 q^T H q - f^T q   subject to   A_eq q = b_eq,   A_in q >= b_in.            [WEIDNER18, Eq. 12]
///
/// Knows nothing of cloth. `blocks` tells which unknowns belong together (one vertex): a row whose entries all lie in
/// one block is *local* and cheap (it becomes a bound after a change of basis of that block), any other row is general.
struct QpProblem {
  SparseMatrix H;         ///< n x n, symmetric positive semidefinite, both triangles stored, columns sorted
  VecX f;                 ///< n
  SparseRows A_eq, A_in;  ///< m_eq x n, m_in x n (0 rows allowed)
  VecX b_eq, b_in;
  std::vector<int> blocks;  ///< ascending starts, last entry n; empty = every unknown its own block
};

enum class QpStatus {
  Solved,
  Infeasible,       ///< no q meets the constraints
  Unbounded,        ///< the objective falls without end along a feasible ray
  IterationLimit,   ///< budget spent; q is the best found
  NumericalTrouble  ///< not finite, or the KKT residual could not be brought below the tolerance
};
const char* to_string(QpStatus status);

/// Primal and dual solution. Stationarity: H q - f = A_eq^T lambda_eq + A_in^T lambda_in, lambda_in >= 0.
struct QpResult {
  QpStatus status = QpStatus::NumericalTrouble;
  VecX q;  ///< finite whenever status is Solved or IterationLimit; else empty
  VecX lambda_eq, lambda_in;
  std::vector<char> active;  ///< one an inequality: 1 = held at its bound
  int iterations = 0;
  bool fell_back = false;   ///< the method asked for gave up and the reference answered
  double kkt_residual = 0;  ///< see kkt_residual()
  std::string message;      ///< for the reader when not Solved
};

struct QpOptions {
  double tolerance = 1e-8;   ///< on the relative KKT residual
  int max_iterations = 200;  ///< of the method asked for; what it falls back on has a budget of its own
};

/// Largest relative violation of the four KKT conditions (stationarity, primal, dual, complementarity).
/// Stationarity and dual (|a_i|_inf lambda_i) are divided by max(1e-300, |f|_inf, |H q|_inf, |A^T lambda|_inf,
/// 1e-5 |H|_inf |q|_inf), the last of which keeps rounding in H q below 1e-8; primal, row by row, by max(1e-300, |b_i|,
/// |a_i|_1 max(|q|_inf, |f|_inf / |H|_inf)); complementarity by both. So the number depends neither on units nor on the
/// scaling of a row, and stays meaningful where the minimiser is q = 0. Infinite if a shape is wrong or a number is not
/// finite.
double kkt_residual(const QpProblem& problem, const VecX& q, const VecX& lambda_eq, const VecX& lambda_in);

/// Shapes, finite numbers, symmetry pattern, sorted blocks; throws std::invalid_argument.
void require_valid(const QpProblem& problem);

}  // namespace crease
