// SPDX-License-Identifier: MIT
#include "working_set_search.hpp"
#include "max_abs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace crease {
namespace {

/// Share of the largest unknown (force) by which a bound (multiplier) may miss its sign: what is left of rounding in a
/// refined solution. Ties, where slack and multiplier are both zero, would flip for ever without it.
constexpr double tie_share = 1e-11;
/// Block exchanges that may pass without fewer wrong signs. Cloth needs none; a cycle needs the backup.
constexpr int patience_limit = 6;
/// Steps of the backup that count as one iteration: each changes one constraint only.
constexpr int single_steps = 20;
constexpr int refinements = 2;
/// Share of the largest force (unknown) that is rounding of the sums in an equation: of some fifty products, through a
/// solve. A further solve would gain less than the certificate can see.
constexpr double rounding_share = 1e-13;

}  // namespace

WorkingSetSearch::WorkingSetSearch(const ReducedQp& qp, KktSystem& kkt, int max_iterations)
    : qp_(qp),
      kkt_(kkt),
      point_{VecX::Zero(qp.size()), VecX::Zero(qp.n_rows())},
      gradient_(-qp.f),
      max_iterations_(max_iterations) {}

SearchStatus WorkingSetSearch::run(Precision precision, WorkingSet& set) {
  anchor_ = point_;
  precision_ = precision;
  return exchange_blocks(set);
}

void WorkingSetSearch::go_on(double times) {
  point_.row_lambda += times * way();
  for (int w = 0; w < qp_.n_rows(); ++w)
    if (is_inequality(qp_.size() + w)) point_.row_lambda[w] = std::max(0.0, point_.row_lambda[w]);
  update_gradient();
}

void WorkingSetSearch::update_gradient() {
  gradient_ = multiply(*qp_.graph, qp_.H, point_.u) - qp_.f;
  if (qp_.n_rows() > 0) gradient_ -= qp_.rows.transpose() * point_.row_lambda;
}

/// Puts every wrong sign right at once, as long as that makes them fewer.
SearchStatus WorkingSetSearch::exchange_blocks(WorkingSet& set) {
  size_t fewest = std::numeric_limits<size_t>::max();
  for (int patience = patience_limit; patience >= 0;) {
    if (iterations_ >= max_iterations_) return SearchStatus::IterationLimit;
    ++iterations_;
    if (!solve(set)) return SearchStatus::Singular;
    std::vector<int> flips = wrong(set, signs());
    if (flips.empty() && precision_ == Precision::Refined && refine(set)) flips = wrong(set, signs());
    if (flips.empty()) return SearchStatus::Optimal;
    if (flips.size() < fewest) {
      fewest = flips.size();
      patience = patience_limit;
    } else {
      --patience;
    }
    for (const int item : flips) state(set, item) ^= 1;
  }
  return ascend_dual(set);
}

/// Adds the most violated constraint, one at a time, and drops those that come to pull. Every constraint admitted
/// raises the dual objective, so no working set comes back.                                              [GI83]
SearchStatus WorkingSetSearch::ascend_dual(WorkingSet& set) {
  SearchStatus status = make_dual_feasible(set);
  while (status == SearchStatus::Optimal) {
    refine(set);
    const Signs sign = signs();
    int worst = -1;
    for (int i = 0; i < sign.slack.size(); ++i)
      if (is_inequality(i) && !state(set, i) && sign.slack[i] < sign.least_slack[i] &&
          (worst < 0 || sign.slack[i] < sign.slack[worst]))
        worst = i;
    if (worst < 0) return SearchStatus::Optimal;
    status = admit(worst, sign.lambda, set);
  }
  return status;
}

SearchStatus WorkingSetSearch::make_dual_feasible(WorkingSet& set) {
  for (bool dropped = true; dropped;) {
    if (iterations_ >= max_iterations_) return SearchStatus::IterationLimit;
    ++iterations_;
    if (!solve(set)) return SearchStatus::Singular;
    const Signs sign = signs();
    dropped = false;
    for (int i = 0; i < sign.lambda.size(); ++i) {
      if (!is_inequality(i) || !state(set, i) || sign.lambda[i] >= sign.least_lambda[i]) continue;
      state(set, i) = 0;
      dropped = true;
    }
  }
  return SearchStatus::Optimal;
}

/// Moves the multipliers from those of `set` towards those of `set` with `item`; where one would turn negative first,
/// its constraint leaves and the move goes on from there.
SearchStatus WorkingSetSearch::admit(int item, const VecX& start_lambda, WorkingSet& set) {
  VecX lambda = start_lambda.cwiseMax(0.0);
  lambda[item] = 0;
  state(set, item) = 1;
  for (;;) {
    if (++single_iterations_ % single_steps == 0) ++iterations_;
    if (iterations_ >= max_iterations_) return SearchStatus::IterationLimit;
    if (!solve(set)) return SearchStatus::Singular;
    const Signs sign = signs();
    double step = 1;
    int blocking = -1;
    for (int i = 0; i < lambda.size(); ++i) {
      if (i == item || !is_inequality(i) || !state(set, i) || sign.lambda[i] >= sign.least_lambda[i]) continue;
      const double until_zero = lambda[i] / (lambda[i] - sign.lambda[i]);
      if (until_zero < step) step = until_zero, blocking = i;
    }
    if (blocking < 0) return SearchStatus::Optimal;
    for (int i = 0; i < lambda.size(); ++i)
      if (is_inequality(i) && state(set, i)) lambda[i] = std::max(0.0, lambda[i] + step * (sign.lambda[i] - lambda[i]));
    state(set, blocking) = 0;
    lambda[blocking] = 0;
  }
}

WorkingSetSearch::Rest WorkingSetSearch::rest(const WorkingSet& set) const {
  Rest rest{-gradient_, qp_.rhs - qp_.rows * point_.u};
  if (kkt_.epsilon() > 0) rest.force -= kkt_.epsilon() * (point_.u - anchor_.u);
  for (int i = 0; i < qp_.size(); ++i)
    if (set.held[i]) rest.force[i] = 0;  // its multiplier takes it up
  for (int w = 0; w < qp_.n_rows(); ++w) {
    // A row gets its softness when it is first on; until then its multiplier and the anchor's are zero.
    rest.rows[w] -= kkt_.delta(w) * (point_.row_lambda[w] - anchor_.row_lambda[w]);
    if (!set.on[w]) rest.rows[w] = 0;
  }
  return rest;
}

double WorkingSetSearch::force_rounding() const {
  return rounding_share * std::max(max_abs(qp_.f), max_abs(gradient_));
}

bool WorkingSetSearch::is_rounding(const Rest& rest) const {
  return max_abs(rest.force) <= force_rounding() &&
         max_abs(rest.rows) <= rounding_share * std::max(max_abs(qp_.rhs), max_abs(point_.u));
}

/// Moves the point to the solution of the equations of `set`.
bool WorkingSetSearch::solve(const WorkingSet& set) {
  bool let_go = false;  // multipliers of rows that are off now
  for (int w = 0; w < qp_.n_rows(); ++w)
    if (!set.on[w] && point_.row_lambda[w] != 0) point_.row_lambda[w] = 0, let_go = true;
  if (let_go) update_gradient();
  Rest missing = rest(set);
  const double rounding = force_rounding();
  for (double& force : missing.force)
    if (iterations_ > 1 && std::abs(force) <= rounding) force = 0;  // what a solve has left, not what is given
  VecX way = VecX::Zero(qp_.size());                                // of the held coordinates to their bounds
  for (int i = 0; i < qp_.size(); ++i)
    if (set.held[i]) way[i] = qp_.bound[i] - point_.u[i];
  ReducedPoint correction;
  if (!kkt_.solve(set, missing.force, way, missing.rows, correction)) return false;
  point_.u += correction.u;
  point_.row_lambda += correction.row_lambda;
  for (int i = 0; i < qp_.size(); ++i)
    if (set.held[i]) point_.u[i] = qp_.bound[i];
  update_gradient();
  return true;
}

/// Solves again as long as more than rounding is left of the equations of `set`. @return whether it had to
bool WorkingSetSearch::refine(const WorkingSet& set) {
  bool moved = false;
  for (int pass = 0; pass < refinements && !is_rounding(rest(set)); ++pass) {
    if (!solve(set)) break;
    moved = true;
  }
  return moved;
}

WorkingSetSearch::Signs WorkingSetSearch::signs() const {
  const ReducedPoint& point = point_;
  const int n = qp_.size();
  const int m = qp_.n_rows();
  Signs sign{VecX(n + m), VecX(n + m), VecX(), VecX()};
  sign.lambda << gradient_, point.row_lambda;
  if (kkt_.epsilon() > 0) sign.lambda.head(n) += kkt_.epsilon() * (point.u - anchor_.u);
  sign.slack << point.u - qp_.bound, qp_.rows * point.u - qp_.rhs;
  for (int w = 0; w < m; ++w) sign.slack[n + w] += kkt_.delta(w) * (point.row_lambda[w] - anchor_.row_lambda[w]);
  // Both scales are those of the unknowns and forces as given; `unit` takes them to each coordinate and row.
  const auto unit = qp_.unit.head(n);
  const double f = max_abs(qp_.f.cwiseProduct(unit));
  const double force = std::max(f, max_abs(VecX((sign.lambda.head(n) + qp_.f).cwiseProduct(unit))));
  const double q =
      std::max({max_abs(point.u.cwiseQuotient(unit)), max_abs(qp_.bound.cwiseQuotient(unit)),
                max_abs(qp_.rhs.cwiseQuotient(qp_.unit.tail(m))), n > 0 ? f / std::pow(unit.maxCoeff(), 2) : 0.0});
  const double tiny = std::numeric_limits<double>::min();
  sign.least_slack = -(tie_share * q) * qp_.unit - VecX::Constant(n + m, tiny);
  sign.least_lambda = -(tie_share * force) * qp_.unit.cwiseInverse() - VecX::Constant(n + m, tiny);
  return sign;
}

std::vector<int> WorkingSetSearch::wrong(const WorkingSet& set, const Signs& sign) const {
  const int n = qp_.size();
  std::vector<int> items;
  for (int i = 0; i < sign.slack.size(); ++i) {
    if (!is_inequality(i)) continue;
    const bool active = i < n ? set.held[i] : set.on[i - n];
    if (active ? sign.lambda[i] < sign.least_lambda[i] : sign.slack[i] < sign.least_slack[i]) items.push_back(i);
  }
  return items;
}

bool WorkingSetSearch::is_inequality(int item) const {
  const int n = qp_.size();
  return item < n ? qp_.kind[item] == Coordinate::Bounded : item - n >= qp_.n_equalities;
}

char& WorkingSetSearch::state(WorkingSet& set, int item) const {
  const int n = qp_.size();
  return item < n ? set.held[item] : set.on[item - n];
}

}  // namespace crease
