// SPDX-License-Identifier: MIT
#include "crease/solver/linear_solver.hpp"

#include <utility>

#include "block_pattern.hpp"
#include "crease/base/require.hpp"
#include "entry.hpp"
#include "sparse_cholesky.hpp"

namespace crease {
namespace {

/// One halves the rounding of a factorisation that went well; a second one finds nothing left.
constexpr int refinements = 2;

}  // namespace

struct LinearSolver::Impl {
  BlockPattern pattern;
  SparseCholesky cholesky;
  bool analyzed = false;

  VecX solve(const VecX& f) { return cholesky.backward(cholesky.forward(f)); }
};

LinearSolver::LinearSolver() : impl_(std::make_unique<Impl>()) {}
LinearSolver::~LinearSolver() = default;
LinearSolver::LinearSolver(LinearSolver&&) noexcept = default;

QpResult LinearSolver::solve(const QpProblem& problem, const QpOptions& options) {
  require_valid(problem, options, {});
  require(problem.b_eq.size() == 0 && problem.b_in.size() == 0, "LinearSolver: expected no constraints, got " +
                                                                    std::to_string(problem.b_eq.size()) + " and " +
                                                                    std::to_string(problem.b_in.size()));
  if (std::optional<QpResult> rest = solve_at_rest(problem)) return *std::move(rest);
  QpResult result;
  if (impl_->pattern.update(problem) || !impl_->analyzed)
    impl_->analyzed =
        impl_->cholesky.analyze(problem.H, impl_->pattern.starts(), impl_->pattern.outer(), impl_->pattern.inner());
  if (!impl_->analyzed || !impl_->cholesky.factorize(problem.H)) {
    result.message = "H is not positive definite";
    return result;
  }
  VecX q = impl_->solve(problem.f);
  for (int i = 0; i < refinements; ++i) q += impl_->solve(problem.f - problem.H * q);
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
