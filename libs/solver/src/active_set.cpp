// SPDX-License-Identifier: MIT
#include "active_set.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "certificates.hpp"
#include "entry.hpp"

namespace crease {
namespace {

/// Lifts of the unit diagonal of H, tried in turn. The first leaves the problem as it is; the others make a singular H
/// regular and cost proximal steps, the fewer the smaller the lift.
constexpr double lifts[] = {0, 1e-10, 1e-8, 1e-6};
constexpr int max_proximal_steps = 40;
/// Where rows depend on each other but for an angle whose square is below their softness, multipliers a million times
/// the forces may hold the solution, and proximal steps go there in equal small strides. From this ratio of a stride to
/// the one before, the sum of the geometric series is taken instead, up to so many strides.
constexpr double slow_ratio = 0.5, most_strides = 1e6;
/// Residual a proximal step aims at; below it there is only rounding to gain.
constexpr double residual_goal = 1e-12;
/// Residual of a first point, where there is neither softness nor lift, with which it need not be refined. Stiff cloth
/// leaves some 1e-12, whether refined or not.
constexpr double good_residual = 1e-11;

class Strides {
 public:
  /// How many times the way of the last step is still to be gone, by the step before; 0 where that is not to be seen.
  double times_left(VecX way) {
    const double ratio = last_.squaredNorm() > 0 ? way.dot(last_) / last_.squaredNorm() : 0;
    const bool slow = ratio > slow_ratio;
    last_ = slow ? VecX() : std::move(way);
    if (!slow) return 0;
    return ratio < 1 ? std::min(ratio / (1 - ratio), most_strides) : most_strides;
  }

 private:
  VecX last_;  // empty after one that was lengthened, which says nothing of the next
};

}  // namespace

QpResult ActiveSetSolver::solve(const QpProblem& problem, const QpOptions& options, std::span<const char> guess) {
  const Checked checked = require_valid(problem, options, guess, &reduction_.pattern());
  if (std::optional<QpResult> rest = solve_at_rest(problem)) return *std::move(rest);
  QpResult result;
  if (!reduction_.build(problem, checked)) {
    result.status = QpStatus::Infeasible;
    result.message = "constraints of one block contradict each other";
    return result;
  }
  if (!kkt_.analyze(reduction_.pattern())) {
    result.message = "out of memory in the analysis of H";
    return result;
  }
  int iterations = 0;
  Attempt attempt = Attempt::Inexact;
  for (const double lift : lifts) {
    attempt = this->attempt(problem, options, guess, lift, result);
    iterations += result.iterations;
    result.iterations = iterations;
    if (attempt == Attempt::Decided) return result;
    if (attempt == Attempt::BudgetSpent) break;
  }
  if (attempt == Attempt::Singular) {
    // An interior point could still stop at a saddle and take it for a solution.
    result.message = "H is not positive semidefinite where the constraints leave it free";
    return result;
  }
  return fall_back(problem, options, guess, std::move(result));
}

// The interior point of our own is asked first; whether there is a solution at all, Ipopt tells.
QpResult ActiveSetSolver::fall_back(const QpProblem& problem, const QpOptions& options, std::span<const char> guess,
                                    QpResult best) {
  QpOptions own_budget;
  own_budget.tolerance = options.tolerance;
  QpResult result;
  for (const QpMethod method : {QpMethod::InteriorPoint, QpMethod::Ipopt}) {
    result = make_qp_solver(method)->solve(problem, own_budget, guess);
    result.iterations += best.iterations;
    result.fell_back = true;
    if (result.status == QpStatus::Solved) return result;
    best.iterations = result.iterations;
  }
  const bool undecided = result.status == QpStatus::IterationLimit || result.status == QpStatus::NumericalTrouble;
  if (undecided && best.status == QpStatus::IterationLimit) {
    best.fell_back = true;
    best.message += "; " + result.message;
    return best;
  }
  result.message = "active set gave up; " + result.message;
  return result;
}

ActiveSetSolver::Attempt ActiveSetSolver::attempt(const QpProblem& problem, const QpOptions& options,
                                                  std::span<const char> guess, double epsilon, QpResult& result) {
  const ReducedQp& qp = reduction_.reduced();
  kkt_.reset(qp, epsilon);
  WorkingSet set = reduction_.start(guess);
  WorkingSetSearch search(qp, kkt_, options.max_iterations);
  QpResult best, former;
  Strides strides;
  best.kkt_residual = std::numeric_limits<double>::infinity();
  const auto finish = [&](QpResult answer, QpStatus status, const char* message) {
    result = std::move(answer);
    result.iterations = search.iterations();
    result.status = status;
    result.message = message;
    return Attempt::Decided;
  };
  using Precision = WorkingSetSearch::Precision;
  // The first point is refined only if it has to be: what softness or lift leave in it is more than rounding.
  SearchStatus status = search.run(Precision::Plain, set);
  const auto is_proximal = [&] { return epsilon > 0 || kkt_.is_soft(); };
  for (int step = is_proximal() ? 1 : 0; step <= max_proximal_steps && status != SearchStatus::Singular; ++step) {
    if (step > 0) status = search.run(Precision::Refined, set);
    if (status == SearchStatus::Singular) break;
    QpResult now = read_out(problem, set, search.point(), search.gradient());
    const bool exact = step > 0 && !is_proximal();
    const bool settled = exact || !(now.kkt_residual < 0.5 * best.kkt_residual);
    if (now.kkt_residual < best.kkt_residual || best.q.size() == 0) best = now;
    const double goal = is_proximal() ? residual_goal : good_residual;
    if (best.kkt_residual <= goal || (settled && best.kkt_residual <= options.tolerance))
      return finish(best, QpStatus::Solved, "");
    if (exact || status == SearchStatus::IterationLimit) break;
    if (step > 1) {
      if (proves_infeasible(problem, now.lambda_eq - former.lambda_eq, now.lambda_in - former.lambda_in, now.q))
        return finish({}, QpStatus::Infeasible, "the constraints contradict each other");
      if (epsilon > 0 && proves_unbounded(problem, now.q - former.q))
        return finish({}, QpStatus::Unbounded, "the objective falls without end along a feasible direction");
    }
    former = std::move(now);
    if (const double times = strides.times_left(search.way()); times > 0) search.go_on(times);
  }
  if (best.kkt_residual <= options.tolerance) return finish(best, QpStatus::Solved, "");
  if (status == SearchStatus::IterationLimit) {
    finish(best, QpStatus::IterationLimit, "iteration budget spent");
    return Attempt::BudgetSpent;
  }
  result.iterations = search.iterations();
  return status == SearchStatus::Singular ? Attempt::Singular : Attempt::Inexact;
}

QpResult ActiveSetSolver::read_out(const QpProblem& problem, const WorkingSet& set, const ReducedPoint& point,
                                   const VecX& gradient) const {
  QpResult result;
  result.q = reduction_.to_q(point.u);
  Multipliers lambda = reduction_.to_multipliers(gradient, point.row_lambda, set);
  result.lambda_eq = std::move(lambda.eq);
  result.lambda_in = lambda.in.cwiseMax(0.0);  // a tie may be negative by rounding; what is worse shows in the residual
  result.active = reduction_.active(set);
  result.kkt_residual = kkt_residual(problem, result.q, result.lambda_eq, result.lambda_in);
  return result;
}

}  // namespace crease
