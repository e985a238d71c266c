// SPDX-License-Identifier: MIT
#include "crease/solver/qp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "block_pattern.hpp"
#include "crease/base/require.hpp"
#include "entry.hpp"
#include "max_abs.hpp"

namespace crease {
namespace {

/// Two stored halves of H may differ by the rounding of their sums; more than this share of the largest entry is a
/// mistake of the assembly.
constexpr double symmetry_tolerance = 1e-9;
constexpr double tiny_scale = 1e-300;  ///< stands in for a scale of zero
/// A stiff H takes large forces apart whose sum is small (a light sheet in rigid motion); H q then cannot be closer to
/// f than rounding of |H| |q|, some 1e-13 of it, which has to be a residual below any tolerance asked for (1e-8).
constexpr double cancellation_share = 1e-5;

/// 0 * x is 0 for a finite x and NaN otherwise.
bool is_finite(const double* values, Eigen::Index count) {
  return count == 0 || (Eigen::Map<const VecX>(values, count) * 0.0).sum() == 0.0;
}

template <class Sparse>
bool is_finite(const Sparse& A) {
  return is_finite(A.valuePtr(), A.nonZeros());
}

template <class Sparse>
bool has_sorted_lines(const Sparse& A) {
  for (int line = 0; line < A.outerSize(); ++line) {
    const int end = A.outerIndexPtr()[line + 1];
    for (int at = A.outerIndexPtr()[line]; at < end; ++at) {
      const int index = A.innerIndexPtr()[at];
      if (index < 0 || index >= A.innerSize()) return false;
      if (at + 1 < end && index >= A.innerIndexPtr()[at + 1]) return false;
    }
  }
  return true;
}

/// Size of the largest entry, all of which have to be finite.
double require_finite(const SparseMatrix& H) {
  constexpr Eigen::Index piece = 1024;  // stays in the nearest cache between the two looks at it
  double largest = 0;
  bool finite = true;
  for (Eigen::Index at = 0; at < H.nonZeros(); at += piece) {
    const Eigen::Map<const VecX> entries(H.valuePtr() + at, std::min(piece, H.nonZeros() - at));
    finite = finite && is_finite(entries.data(), entries.size());
    largest = std::max(largest, max_abs(entries));
  }
  require(finite, "QpProblem: expected finite H and f");
  return largest;
}

/// Walks the columns in order; entry (r, c) below the diagonal must meet its mirror as the next one of column r.
/// @param slack  how much the two may differ
bool is_symmetric(const SparseMatrix& H, double slack) {
  const int* outer = H.outerIndexPtr();
  const int* inner = H.innerIndexPtr();
  const double* value = H.valuePtr();
  std::vector<int> next(outer, outer + H.outerSize());
  for (int c = 0; c < H.outerSize(); ++c) {
    int at = next[c];
    if (at < outer[c + 1] && inner[at] < c) return false;  // an upper entry no lower one has asked for
    if (at < outer[c + 1] && inner[at] == c) ++at;
    for (; at < outer[c + 1]; ++at) {
      const int r = inner[at];
      const int mirror = next[r]++;
      if (mirror >= outer[r + 1] || inner[mirror] != c) return false;
      if (std::abs(value[mirror] - value[at]) > slack) return false;
    }
  }
  return true;
}

void require_rows(const SparseRows& A, const VecX& b, Eigen::Index n, const std::string& name) {
  require(A.rows() == b.size(), "QpProblem: expected as many rows in A_" + name + " as in b_" + name + ", got " +
                                    std::to_string(A.rows()) + " and " + std::to_string(b.size()));
  require(A.rows() == 0 || A.cols() == n,
          "QpProblem: expected A_" + name + " with " + std::to_string(n) + " columns, got " + std::to_string(A.cols()));
  require(A.isCompressed() && has_sorted_lines(A), "QpProblem: expected A_" + name + " compressed, columns ascending");
  require(is_finite(A) && is_finite(b.data(), b.size()), "QpProblem: expected finite A_" + name + " and b_" + name);
}

/// Returns the size of its largest entry.
double require_matrix(const QpProblem& problem) {
  const Eigen::Index n = problem.f.size();
  const SparseMatrix& H = problem.H;
  require(H.rows() == n && H.cols() == n, "QpProblem: expected H of size " + std::to_string(n) + ", got " +
                                              std::to_string(H.rows()) + " x " + std::to_string(H.cols()));
  require(H.isCompressed() && has_sorted_lines(H), "QpProblem: expected H compressed, rows ascending in each column");
  const double largest = require_finite(H);
  require(is_symmetric(H, symmetry_tolerance * largest), "QpProblem: expected H symmetric with both triangles stored");
  return largest;
}

/// The same where the pattern is known to be right.
double require_values(const SparseMatrix& H, const BlockPattern& pattern) {
  const double largest = require_finite(H), slack = symmetry_tolerance * largest;
  require(pattern.is_full() ? pattern.asymmetry(H) <= slack : is_symmetric(H, slack),
          "QpProblem: expected H symmetric with both triangles stored");
  return largest;
}

/// All but H.
void require_rest(const QpProblem& problem) {
  const Eigen::Index n = problem.f.size();
  require(is_finite(problem.f.data(), n), "QpProblem: expected finite H and f");
  require_rows(problem.A_eq, problem.b_eq, n, "eq");
  require_rows(problem.A_in, problem.b_in, n, "in");
  const std::vector<int>& blocks = problem.blocks;
  if (blocks.empty()) return;
  require(blocks.front() == 0 && blocks.back() == n, "QpProblem: expected blocks from 0 to " + std::to_string(n) +
                                                         ", got " + std::to_string(blocks.front()) + " to " +
                                                         std::to_string(blocks.back()));
  require(std::adjacent_find(blocks.begin(), blocks.end(), std::greater_equal<int>()) == blocks.end(),
          "QpProblem: expected strictly ascending blocks");
}

/// The worst row of a block of constraints, each violation relative to the row's own size.
struct RowResiduals {
  double primal = 0, dual = 0, complementarity = 0;
};

RowResiduals row_residuals(const SparseRows& A, const VecX& b, const VecX& q, const VecX& lambda, bool equality,
                           double q_scale, double force_scale) {
  RowResiduals worst;
  for (int i = 0; i < A.rows(); ++i) {
    double value = 0, sum = 0, largest = 0;
    for (SparseRows::InnerIterator a(A, i); a; ++a) {
      value += a.value() * q[a.col()];
      sum += std::abs(a.value());
      largest = std::max(largest, std::abs(a.value()));
    }
    const double slack = (value - b[i]) / std::max({tiny_scale, std::abs(b[i]), sum * q_scale});
    const double force = lambda[i] * largest / force_scale;
    worst.primal = std::max(worst.primal, equality ? std::abs(slack) : -slack);
    if (equality) continue;
    worst.dual = std::max(worst.dual, -force);
    worst.complementarity = std::max(worst.complementarity, std::abs(force * slack));
  }
  return worst;
}

struct Product {
  VecX Hq;
  double row_sum = 0;  ///< largest sum of the sizes of a row's entries
};

/// Of a symmetric H, whose columns are its rows.
Product multiply(const SparseMatrix& H, const VecX& q) {
  Product product{VecX(H.cols())};
  const int* row = H.innerIndexPtr();
  const double* entry = H.valuePtr();
  constexpr int chains = 4;  // of additions that need not wait for each other
  for (int c = 0; c < H.outerSize(); ++c) {
    double value[chains] = {}, size[chains] = {};
    int at = H.outerIndexPtr()[c];
    const int end = H.isCompressed() ? H.outerIndexPtr()[c + 1] : at + H.innerNonZeroPtr()[c];
    for (; at + chains <= end; at += chains)
      for (int k = 0; k < chains; ++k) {
        value[k] += entry[at + k] * q[row[at + k]];
        size[k] += std::abs(entry[at + k]);
      }
    for (; at < end; ++at) {
      value[0] += entry[at] * q[row[at]];
      size[0] += std::abs(entry[at]);
    }
    product.Hq[c] = (value[0] + value[1]) + (value[2] + value[3]);
    product.row_sum = std::max(product.row_sum, (size[0] + size[1]) + (size[2] + size[3]));
  }
  return product;
}

}  // namespace

const char* to_string(QpStatus status) {
  switch (status) {
    case QpStatus::Solved:
      return "solved";
    case QpStatus::Infeasible:
      return "infeasible";
    case QpStatus::Unbounded:
      return "unbounded";
    case QpStatus::IterationLimit:
      return "iteration limit";
    case QpStatus::NumericalTrouble:
      return "numerical trouble";
  }
  return "unknown";
}

void require_valid(const QpProblem& problem) {
  require_matrix(problem);
  require_rest(problem);
}

Checked require_valid(const QpProblem& problem, const QpOptions& options, std::span<const char> guess,
                      const BlockPattern* former) {
  const bool same = former != nullptr && former->is_that_of(problem) && problem.f.size() == problem.H.cols();
  const double largest = same ? require_values(problem.H, *former) : require_matrix(problem);
  require_rest(problem);
  require(options.tolerance > 0 && options.max_iterations > 0,
          "QpSolver: expected a positive tolerance and iteration budget");
  require(guess.empty() || static_cast<Eigen::Index>(guess.size()) == problem.b_in.size(),
          "QpSolver: expected a guess for each of " + std::to_string(problem.b_in.size()) + " inequalities, got " +
              std::to_string(guess.size()));
  return {largest, same};
}

std::optional<QpResult> solve_at_rest(const QpProblem& problem) {
  const bool rests = (problem.f.array() == 0).all() && (problem.b_eq.array() == 0).all();
  const bool allowed = (problem.b_in.array() <= 0).all();
  QpResult result;
  if (rests && allowed) {
    result.status = QpStatus::Solved;
    result.q = VecX::Zero(problem.f.size());
    result.lambda_eq = VecX::Zero(problem.b_eq.size());
    result.lambda_in = VecX::Zero(problem.b_in.size());
    for (const double b : problem.b_in) result.active.push_back(b == 0);
    return result;
  }
  if (problem.f.size() > 0) return std::nullopt;
  result.status = QpStatus::Infeasible;
  result.message = "there is no unknown to meet the constraints";
  return result;
}

double kkt_residual(const QpProblem& problem, const VecX& q, const VecX& lambda_eq, const VecX& lambda_in) {
  const Eigen::Index n = problem.f.size();
  const bool shapes =
      q.size() == n && lambda_eq.size() == problem.b_eq.size() && lambda_in.size() == problem.b_in.size();
  if (!shapes || !q.allFinite() || !lambda_eq.allFinite() || !lambda_in.allFinite())
    return std::numeric_limits<double>::infinity();
  const auto [Hq, stiffness] = multiply(problem.H, q);
  VecX reaction = VecX::Zero(n);
  if (lambda_eq.size() > 0) reaction += problem.A_eq.transpose() * lambda_eq;
  if (lambda_in.size() > 0) reaction += problem.A_in.transpose() * lambda_in;
  const double force_scale = std::max(
      {tiny_scale, max_abs(problem.f), max_abs(Hq), max_abs(reaction), cancellation_share * stiffness * max_abs(q)});
  const double q_scale = std::max(max_abs(q), max_abs(problem.f) / std::max(tiny_scale, stiffness));
  const double stationarity = max_abs(Hq - problem.f - reaction) / force_scale;
  const RowResiduals eq = row_residuals(problem.A_eq, problem.b_eq, q, lambda_eq, true, q_scale, force_scale);
  const RowResiduals in = row_residuals(problem.A_in, problem.b_in, q, lambda_in, false, q_scale, force_scale);
  const double worst = std::max({stationarity, eq.primal, in.primal, in.dual, in.complementarity});
  return std::isfinite(worst) ? worst : std::numeric_limits<double>::infinity();
}

}  // namespace crease
