// SPDX-License-Identifier: MIT
#include "scaled_qp.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseQR>

#include "max_abs.hpp"

namespace crease {
namespace {

/// A diagonal entry of H this small beside the largest is rounding of zero.
constexpr double no_diagonal = 1e-13;
/// Equalities: part of a row outside the others that counts as zero, and mismatch of constants that counts as rounding.
constexpr double dependent_share = 1e-10;
constexpr double mismatch_tolerance = 1e-8;
/// Regularisation of the polishing equations; refinement removes its effect.
constexpr double polish_shift = 1e-9;
constexpr int polish_steps = 10;
constexpr int polish_rounds = 5;
constexpr double polish_tie = 1e-13;  ///< on numbers about 1
/// Below this residual two points are equally good, and the polished one has its zeros exact.
constexpr double rounding_share = 1e-11;

/// Rows of `A` that span all of them; `conflict` if no point meets A y = b.
std::vector<int> independent_rows(const SparseMatrix& transposed, const VecX& b, bool& conflict) {
  std::vector<int> rows;
  if (b.size() == 0) return rows;
  Eigen::SparseQR<SparseMatrix, Eigen::COLAMDOrdering<int>> qr;
  qr.setPivotThreshold(dependent_share);
  qr.compute(transposed);
  const auto rank = qr.rank();
  const auto& order = qr.colsPermutation().indices();
  rows.assign(order.data(), order.data() + rank);
  // A P = (Q R)^T with R of `rank` rows: the point Q w with R_1^T w = (P^T b)_1 meets the kept rows.
  const VecX permuted = qr.colsPermutation().transpose() * b;
  const SparseRows sorted = qr.matrixR();  // its columns are not; a change of storage order sorts them
  const SparseMatrix R = SparseMatrix(sorted).topLeftCorner(rank, b.size());
  const SparseMatrix kept = R.leftCols(rank);
  const VecX w = kept.transpose().triangularView<Eigen::Lower>().solve(permuted.head(rank));
  const VecX mismatch = R.transpose() * w - permuted;
  conflict = max_abs(mismatch) > mismatch_tolerance * std::max(max_abs(b), max_abs(w));
  std::sort(rows.begin(), rows.end());
  return rows;
}

/// Solves the equations of the rows that are `on` by refinement, from y and lambda. @return false if they cannot be
bool solve_equations(const ScaledQp& qp, const std::vector<char>& on, VecX& y, VecX& lambda) {
  const int n = static_cast<int>(qp.f.size()), m = static_cast<int>(qp.b.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < n; ++c) {
    for (SparseMatrix::InnerIterator h(qp.H, c); h; ++h) entries.emplace_back(static_cast<int>(h.row()), c, h.value());
    entries.emplace_back(c, c, polish_shift);
  }
  for (int i = 0; i < m; ++i) {
    // A row that is off keeps its place with the equation lambda = 0.
    entries.emplace_back(n + i, n + i, on[i] ? -polish_shift : -1.0);
    if (!on[i]) lambda[i] = 0;
    for (SparseRows::InnerIterator a(qp.A, i); a && on[i]; ++a)
      entries.emplace_back(n + i, static_cast<int>(a.col()), a.value());
  }
  SparseMatrix K(n + m, n + m);
  K.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> ldlt(K);
  if (ldlt.info() != Eigen::Success) return false;
  for (int step = 0; step < polish_steps; ++step) {
    VecX rest(n + m);
    rest << qp.f - qp.H * y + qp.A.transpose() * lambda, qp.b - qp.A * y;
    for (int i = 0; i < m; ++i)
      if (!on[i]) rest[n + i] = 0;
    const VecX correction = ldlt.solve(rest);
    if (!correction.allFinite()) return false;
    y += correction.head(n);
    lambda -= correction.tail(m);
  }
  return true;
}

/// Goes from the interior point, which is only near the solution, to the corner it points at.
bool polish(const ScaledQp& qp, VecX& y, VecX& lambda) {
  const int m = static_cast<int>(qp.b.size());
  VecX slack = qp.A * y - qp.b;
  std::vector<char> on(static_cast<size_t>(m), 1);
  for (int i = qp.n_eq; i < m; ++i) on[i] = lambda[i] > slack[i];
  for (int round = 0; round < polish_rounds; ++round) {
    if (!solve_equations(qp, on, y, lambda)) return false;
    slack = qp.A * y - qp.b;
    bool right = true;
    for (int i = qp.n_eq; i < m; ++i) {
      if (on[i] ? lambda[i] >= -polish_tie : slack[i] >= -polish_tie) continue;
      on[i] ^= 1;
      right = false;
    }
    if (right) return true;
  }
  return false;
}

QpResult unscaled(const QpProblem& problem, const ScaledQp& qp, const VecX& y, const VecX& lambda) {
  QpResult result;
  result.q = qp.size * y.cwiseProduct(qp.scale);
  const VecX multipliers = qp.size * lambda.cwiseQuotient(qp.row_norm);
  result.lambda_eq = VecX::Zero(problem.b_eq.size());
  for (int i = 0; i < qp.n_eq; ++i) result.lambda_eq[qp.eq[i]] = multipliers[i];
  result.lambda_in = multipliers.tail(multipliers.size() - qp.n_eq).cwiseMax(0.0);
  const VecX slack = qp.A * y - qp.b;
  for (int i = qp.n_eq; i < lambda.size(); ++i) result.active.push_back(lambda[i] > slack[i]);
  result.kkt_residual = kkt_residual(problem, result.q, result.lambda_eq, result.lambda_in);
  return result;
}

}  // namespace

ScaledQp::ScaledQp(const QpProblem& problem) {
  const Eigen::Index n = problem.f.size();
  scale = problem.H.diagonal();
  const double largest = n == 0 ? 1.0 : scale.maxCoeff();
  for (double& s : scale) s = 1 / std::sqrt(s > no_diagonal * largest ? s : (largest > 0 ? largest : 1.0));
  H = scale.asDiagonal() * problem.H * scale.asDiagonal();
  f = problem.f.cwiseProduct(scale);
  eq = independent_rows(SparseMatrix(problem.A_eq.transpose()), problem.b_eq, conflict);
  n_eq = static_cast<int>(eq.size());
  const int m = n_eq + static_cast<int>(problem.b_in.size());
  b.resize(m);
  row_norm.resize(m);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < m; ++i) {
    const bool equality = i < n_eq;
    const int source = equality ? eq[i] : i - n_eq;
    const SparseRows& from = equality ? problem.A_eq : problem.A_in;
    double squared = 0;
    for (SparseRows::InnerIterator a(from, source); a; ++a) squared += std::pow(a.value() * scale[a.col()], 2);
    row_norm[i] = squared > 0 ? std::sqrt(squared) : 1.0;
    b[i] = (equality ? problem.b_eq : problem.b_in)[source] / row_norm[i];
    for (SparseRows::InnerIterator a(from, source); a; ++a)
      entries.emplace_back(i, static_cast<int>(a.col()), a.value() * scale[a.col()] / row_norm[i]);
  }
  A.resize(m, n);
  A.setFromTriplets(entries.begin(), entries.end());
  size = std::max(max_abs(f), max_abs(b));
  if (!(size > 0)) size = 1;
  f /= size;
  b /= size;
}

std::optional<QpResult> ScaledQp::refusal() const {
  if (!conflict) return std::nullopt;
  QpResult result;
  result.status = QpStatus::Infeasible;
  result.message = "the equalities contradict each other";
  return result;
}

QpResult ScaledQp::read_out(const QpProblem& problem, const VecX& y, const VecX& lambda) const {
  QpResult result = unscaled(problem, *this, y, lambda);
  VecX corner = y, forces = lambda;
  if (!polish(*this, corner, forces)) return result;
  QpResult polished = unscaled(problem, *this, corner, forces);
  return polished.kkt_residual <= std::max(result.kkt_residual, rounding_share) ? polished : result;
}

}  // namespace crease
