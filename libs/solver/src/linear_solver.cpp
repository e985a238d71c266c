// SPDX-License-Identifier: MIT
#include "crease/solver/linear_solver.hpp"

#include <utility>

#include "block_pattern.hpp"
#include "crease/base/require.hpp"
#include "crease/solver/block_cholesky.hpp"
#include "entry.hpp"

namespace crease {
namespace {

/// One halves the rounding of a factorisation that went well; a second one finds nothing left.
constexpr int refinements = 2;

}  // namespace

struct LinearSolver::Impl {
  BlockPattern pattern;
  std::unique_ptr<BlockCholesky> cholesky;
  SparseMatrix full;  ///< H with every entry of its blocks, unless it stores those itself
  bool analyzed = false;

  void analyze(const QpProblem& problem) {
    if (!pattern.update(problem) && analyzed) return;
    full = pattern.is_full() ? SparseMatrix() : make_block_matrix(pattern.graph());
    analyzed = cholesky->analyze(pattern.graph());
  }

  bool factorize(const SparseMatrix& H) {
    if (pattern.is_full()) return cholesky->factorize(H);
    pattern.gather(H, full.valuePtr());
    return cholesky->factorize(full);
  }
};

LinearSolver::LinearSolver(int threads) : impl_(std::make_unique<Impl>()) {
  impl_->cholesky = make_block_cholesky({.threads = threads});
}
LinearSolver::~LinearSolver() = default;
LinearSolver::LinearSolver(LinearSolver&&) noexcept = default;

QpResult LinearSolver::solve(const QpProblem& problem, const QpOptions& options) {
  require_valid(problem, options, {}, &impl_->pattern);
  require(problem.b_eq.size() == 0 && problem.b_in.size() == 0, "LinearSolver: expected no constraints, got " +
                                                                    std::to_string(problem.b_eq.size()) + " and " +
                                                                    std::to_string(problem.b_in.size()));
  if (std::optional<QpResult> rest = solve_at_rest(problem)) return *std::move(rest);
  QpResult result;
  impl_->analyze(problem);
  if (!impl_->analyzed || !impl_->factorize(problem.H)) {
    result.message = "H is not positive definite";
    return result;
  }
  VecX q = impl_->cholesky->solve(problem.f);
  for (int i = 0; i < refinements; ++i) q += impl_->cholesky->solve(problem.f - problem.H * q);
  result.kkt_residual = kkt_residual(problem, q, VecX(), VecX());
  if (result.kkt_residual <= options.tolerance) {
    result.status = QpStatus::Solved;
    result.q = std::move(q);
  } else {
    result.message = "H is too near to singular";
  }
  return result;
}

}  // namespace crease
