// SPDX-License-Identifier: MIT
#include "interior_point.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/SparseCholesky>

#include "entry.hpp"
#include "max_abs.hpp"
#include "scaled_qp.hpp"

namespace crease {
namespace {

/// Makes the KKT matrix quasi-definite, so that it has factors L D L^T in any order [VANDERBEI95]; refinement removes
/// its effect.
constexpr double shift = 1e-9;
constexpr int refinements = 4;
/// Share of the way to the nearest bound that a step goes.
constexpr double way_share = 0.995;
/// Aimed at, on numbers about 1; what is left is for the corner that the point is near.
constexpr double goal = 1e-11;
/// Iterations without a better point after which there is none to be had.
constexpr int patience = 15;

/// Of inequalities a slack s > 0 and a multiplier > 0 each; the equalities' multipliers come before those.
struct Point {
  VecX y, s, lambda;
};

class InteriorPoint {
 public:
  explicit InteriorPoint(const ScaledQp& qp);

  /// @return false if it cannot go on from here
  bool iterate();
  bool start();
  const Point& point() const { return at_; }
  /// Largest of the violations of the KKT conditions.
  double residual() const;

 private:
  Eigen::Index n_eq() const { return qp_.n_eq; }
  Eigen::Index n_in() const { return qp_.b.size() - qp_.n_eq; }
  VecX forces() const { return at_.lambda.tail(n_in()); }
  VecX dual() const { return qp_.f - qp_.H * at_.y + qp_.A.transpose() * at_.lambda; }
  VecX primal() const;
  bool factorize();
  bool solve(const VecX& complementarity, Point& step) const;
  double longest(const Point& step) const;
  void go(const Point& step, double way);

  const ScaledQp& qp_;
  Point at_;
  VecX diagonal_;  // s / lambda of inequalities, 0 of equalities
  SparseMatrix K_;
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> ldlt_;
};

InteriorPoint::InteriorPoint(const ScaledQp& qp) : qp_(qp) {
  const int n = static_cast<int>(qp.f.size()), m = static_cast<int>(qp.b.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < n; ++c) {
    for (SparseMatrix::InnerIterator h(qp.H, c); h; ++h)
      if (h.row() >= c) entries.emplace_back(static_cast<int>(h.row()), c, h.value());
    entries.emplace_back(c, c, shift);
  }
  for (int i = 0; i < m; ++i) {
    entries.emplace_back(n + i, n + i, -shift);
    for (SparseRows::InnerIterator a(qp.A, i); a; ++a)
      entries.emplace_back(n + i, static_cast<int>(a.col()), a.value());
  }
  K_.resize(n + m, n + m);
  K_.setFromTriplets(entries.begin(), entries.end());
  ldlt_.analyzePattern(K_);
}

// A y = b, A y - s = b.
VecX InteriorPoint::primal() const {
  VecX rest = qp_.b - qp_.A * at_.y;
  rest.tail(n_in()) += at_.s;
  return rest;
}

double InteriorPoint::residual() const {
  return std::max({max_abs(dual()), max_abs(primal()), max_abs(at_.s.cwiseProduct(forces()))});
}

bool InteriorPoint::factorize() {
  const Eigen::Index n = qp_.f.size();
  diagonal_ = VecX::Zero(qp_.b.size());
  diagonal_.tail(n_in()) = at_.s.cwiseQuotient(forces());
  for (Eigen::Index i = 0; i < diagonal_.size(); ++i) K_.coeffRef(n + i, n + i) = -shift - diagonal_[i];
  ldlt_.factorize(K_);
  return ldlt_.info() == Eigen::Success;
}

// The step after which the linearised conditions hold, with s lambda grown by `complementarity`:
//   H dy - A^T dlambda = dual,   A dy - ds = primal,   lambda ds + s dlambda = complementarity.
bool InteriorPoint::solve(const VecX& complementarity, Point& step) const {
  const Eigen::Index n = qp_.f.size(), m = qp_.b.size();
  const VecX lack = primal();
  VecX right(n + m);
  right << dual(), lack;
  right.tail(n_in()) += complementarity.cwiseQuotient(forces());
  VecX way = VecX::Zero(n + m);  // dy, -dlambda
  for (int k = 0; k <= refinements; ++k) {
    VecX rest = right;
    rest.head(n) -= qp_.H * way.head(n) + qp_.A.transpose() * way.tail(m);
    rest.tail(m) -= qp_.A * way.head(n) - diagonal_.cwiseProduct(way.tail(m));
    const VecX more = ldlt_.solve(rest);
    if (!more.allFinite()) return false;
    way += more;
  }
  step.y = way.head(n);
  step.lambda = -way.tail(m);
  step.s = (qp_.A * step.y - lack).tail(n_in());
  return step.y.allFinite() && step.s.allFinite() && step.lambda.allFinite();
}

double InteriorPoint::longest(const Point& step) const {
  double way = 1 / way_share;
  for (Eigen::Index i = 0; i < n_in(); ++i) {
    const double force = at_.lambda[n_eq() + i], dforce = step.lambda[n_eq() + i];
    if (step.s[i] < 0) way = std::min(way, -at_.s[i] / step.s[i]);
    if (dforce < 0) way = std::min(way, -force / dforce);
  }
  return way;
}

void InteriorPoint::go(const Point& step, double way) {
  at_.y += way * step.y;
  at_.s += way * step.s;
  at_.lambda += way * step.lambda;
}

// Where the rows taken for equations, softened by 1, would hold it; with slacks and multipliers moved off zero.
bool InteriorPoint::start() {
  at_ = {VecX::Zero(qp_.f.size()), VecX::Ones(n_in()), VecX::Ones(qp_.b.size())};
  at_.lambda.head(n_eq()).setZero();
  Point step;
  if (!factorize() || !solve(-at_.s.cwiseProduct(forces()), step)) return false;
  go(step, 1);
  const auto lift = [](auto&& values) {
    if (values.size() == 0) return;
    values.array() += std::max(0.0, -1.5 * values.minCoeff()) + 1e-3;
  };
  lift(at_.s);
  lift(at_.lambda.tail(n_in()));
  return true;
}

bool InteriorPoint::iterate() {
  Point step;
  const VecX product = at_.s.cwiseProduct(forces());
  if (!factorize() || !solve(-product, step)) return false;
  if (n_in() > 0) {
    const double mean = product.mean(), way = std::min(1.0, longest(step));
    const VecX s = at_.s + way * step.s, force = forces() + way * step.lambda.tail(n_in());
    const double centring = std::pow(s.dot(force) / static_cast<double>(n_in()) / mean, 3);
    const VecX second = step.s.cwiseProduct(step.lambda.tail(n_in()));
    if (!solve((centring * mean - product.array() - second.array()).matrix(), step)) return false;
  }
  go(step, std::min(1.0, way_share * longest(step)));
  return at_.y.allFinite() && at_.lambda.allFinite();
}

class InteriorPointSolver : public QpSolver {
 public:
  QpResult solve(const QpProblem& problem, const QpOptions& options, std::span<const char> guess) override;
};

QpResult InteriorPointSolver::solve(const QpProblem& problem, const QpOptions& options, std::span<const char> guess) {
  require_valid(problem, options, guess);
  if (std::optional<QpResult> rest = solve_at_rest(problem)) return *std::move(rest);
  const ScaledQp qp(problem);
  if (std::optional<QpResult> refused = qp.refusal()) return *std::move(refused);
  QpResult result;
  InteriorPoint search(qp);
  Point best;
  double least = HUGE_VAL;
  int iterations = 0, since_best = 0;
  for (bool goes_on = search.start(); goes_on; goes_on = search.iterate()) {
    const double residual = search.residual();
    if (residual < least) best = search.point(), least = residual, since_best = 0;
    if (least <= goal || ++since_best > patience || iterations == options.max_iterations) break;
    ++iterations;
  }
  if (best.y.size() > 0) result = qp.read_out(problem, best.y, best.lambda);
  result.iterations = iterations;
  if (best.y.size() > 0 && result.kkt_residual <= options.tolerance) {
    result.status = QpStatus::Solved;
    return result;
  }
  result.status = iterations == options.max_iterations ? QpStatus::IterationLimit : QpStatus::NumericalTrouble;
  result.message = "the interior point found no solution";
  if (result.status == QpStatus::NumericalTrouble) result.q.resize(0);
  return result;
}

}  // namespace

std::unique_ptr<QpSolver> make_interior_point_solver() {
  return std::make_unique<InteriorPointSolver>();
}

}  // namespace crease
