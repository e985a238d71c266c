// SPDX-License-Identifier: MIT
// The only file that calls Ipopt [WAECHTER06].
#include "ipopt.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseQR>
#include <IpIpoptApplication.hpp>
#include <IpSolveStatistics.hpp>
#include <IpTNLP.hpp>
#include <algorithm>
#include <cmath>
#include <limits>

#include "entry.hpp"
#include "one_thread.hpp"

namespace crease {
namespace {

constexpr double no_bound = 2e19;  ///< Ipopt takes 1e19 and more for no bound

/// A diagonal entry of H this small beside the largest is rounding of zero.
constexpr double no_diagonal = 1e-13;
/// Equalities: part of a row outside the others that counts as zero, and mismatch of constants that counts as rounding.
constexpr double dependent_share = 1e-10;
constexpr double mismatch_tolerance = 1e-8;
/// Asked of Ipopt, on the scaled problem.
constexpr double ipopt_tolerance = 1e-11;
/// Regularisation of the polishing equations; refinement removes its effect.
constexpr double polish_shift = 1e-9;
constexpr int polish_steps = 10;
constexpr int polish_rounds = 5;
constexpr double polish_tie = 1e-13;  ///< on numbers about 1
/// Below this residual two points are equally good, and the polished one has its zeros exact.
constexpr double rounding_share = 1e-11;

double max_abs(const VecX& v) {
  return v.size() == 0 ? 0.0 : v.cwiseAbs().maxCoeff();
}

/// The problem in q = size * scale .* y with a unit diagonal of H, unit rows and numbers about 1, as Ipopt's absolute
/// tolerances like it.
struct ScaledQp {
  SparseMatrix H;
  VecX f;
  SparseRows A;  ///< equalities first
  VecX b;
  int n_eq = 0;
  VecX scale, row_norm;
  double size = 1;
  std::vector<int> eq;    ///< equalities kept: the largest independent set, which Ipopt cannot do without
  bool conflict = false;  ///< one of the others contradicts them

  explicit ScaledQp(const QpProblem& problem);
};

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

/// Ipopt's view of a ScaledQp. Derivatives are constant, and Ipopt is told so.
class QpNlp : public Ipopt::TNLP {
 public:
  explicit QpNlp(const ScaledQp& qp) : qp_(qp) {}

  VecX y, lambda;
  Ipopt::SolverReturn outcome = Ipopt::INTERNAL_ERROR;

  bool get_nlp_info(int& n, int& m, int& nnz_jac_g, int& nnz_h_lag, IndexStyleEnum& style) override {
    n = static_cast<int>(qp_.f.size());
    m = static_cast<int>(qp_.b.size());
    nnz_jac_g = static_cast<int>(qp_.A.nonZeros());
    nnz_h_lag = 0;
    for_lower([&](int, int, double) { ++nnz_h_lag; });
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(int n, double* x_l, double* x_u, int m, double* g_l, double* g_u) override {
    std::fill(x_l, x_l + n, -no_bound);
    std::fill(x_u, x_u + n, no_bound);
    std::copy(qp_.b.data(), qp_.b.data() + m, g_l);
    std::copy(qp_.b.data(), qp_.b.data() + qp_.n_eq, g_u);
    std::fill(g_u + qp_.n_eq, g_u + m, no_bound);
    return true;
  }
  bool get_starting_point(int n, bool, double* x, bool, double*, double*, int, bool, double*) override {
    std::fill(x, x + n, 0.0);
    return true;
  }
  bool eval_f(int n, const double* x, bool, double& value) override {
    const Eigen::Map<const VecX> q(x, n);
    value = 0.5 * q.dot(qp_.H * q) - qp_.f.dot(q);
    return true;
  }
  bool eval_grad_f(int n, const double* x, bool, double* gradient) override {
    Eigen::Map<VecX>(gradient, n) = qp_.H * Eigen::Map<const VecX>(x, n) - qp_.f;
    return true;
  }
  bool eval_g(int n, const double* x, bool, int m, double* g) override {
    Eigen::Map<VecX>(g, m) = qp_.A * Eigen::Map<const VecX>(x, n);
    return true;
  }
  bool eval_jac_g(int, const double*, bool, int m, int, int* row, int* column, double* values) override {
    for (int i = 0; i < m; ++i)
      for (SparseRows::InnerIterator a(qp_.A, i); a; ++a)
        if (values)
          *values++ = a.value();
        else
          *row++ = i, *column++ = static_cast<int>(a.col());
    return true;
  }
  bool eval_h(int, const double*, bool, double factor, int, const double*, bool, int, int* row, int* column,
              double* values) override {
    for_lower([&](int r, int c, double value) {
      if (values)
        *values++ = factor * value;
      else
        *row++ = r, *column++ = c;
    });
    return true;
  }
  void finalize_solution(Ipopt::SolverReturn status, int n, const double* x, const double*, const double*, int m,
                         const double*, const double* multiplier, double, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    outcome = status;
    y = Eigen::Map<const VecX>(x, n);
    lambda = -Eigen::Map<const VecX>(multiplier, m);  // Ipopt's Lagrangian is f + lambda g
  }

 private:
  template <class Visit>
  void for_lower(Visit visit) const {
    for (int c = 0; c < qp_.H.outerSize(); ++c)
      for (SparseMatrix::InnerIterator h(qp_.H, c); h; ++h)
        if (h.row() >= c) visit(static_cast<int>(h.row()), c, h.value());
  }

  const ScaledQp& qp_;
};

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

class IpoptSolver : public QpSolver {
 public:
  QpResult solve(const QpProblem& problem, const QpOptions& options, std::span<const char> guess) override;
};

QpResult read_out(const QpProblem& problem, const ScaledQp& qp, const VecX& y, const VecX& lambda) {
  QpResult result;
  result.q = qp.size * y.cwiseProduct(qp.scale);
  const VecX unscaled = qp.size * lambda.cwiseQuotient(qp.row_norm);
  result.lambda_eq = VecX::Zero(problem.b_eq.size());
  for (int i = 0; i < qp.n_eq; ++i) result.lambda_eq[qp.eq[i]] = unscaled[i];
  result.lambda_in = unscaled.tail(unscaled.size() - qp.n_eq).cwiseMax(0.0);
  const VecX slack = qp.A * y - qp.b;
  for (int i = qp.n_eq; i < lambda.size(); ++i) result.active.push_back(lambda[i] > slack[i]);
  result.kkt_residual = kkt_residual(problem, result.q, result.lambda_eq, result.lambda_in);
  return result;
}

QpStatus to_status(Ipopt::ApplicationReturnStatus status) {
  switch (status) {
    case Ipopt::Solve_Succeeded:
    case Ipopt::Solved_To_Acceptable_Level:
    case Ipopt::Search_Direction_Becomes_Too_Small:
    case Ipopt::Feasible_Point_Found:
      return QpStatus::Solved;
    case Ipopt::Infeasible_Problem_Detected:
      return QpStatus::Infeasible;
    case Ipopt::Diverging_Iterates:
      return QpStatus::Unbounded;
    case Ipopt::Maximum_Iterations_Exceeded:
    case Ipopt::Maximum_CpuTime_Exceeded:
      return QpStatus::IterationLimit;
    case Ipopt::User_Requested_Stop:
    case Ipopt::Restoration_Failed:
    case Ipopt::Error_In_Step_Computation:
    case Ipopt::Not_Enough_Degrees_Of_Freedom:
    case Ipopt::Invalid_Problem_Definition:
    case Ipopt::Invalid_Option:
    case Ipopt::Invalid_Number_Detected:
    case Ipopt::Unrecoverable_Exception:
    case Ipopt::NonIpopt_Exception_Thrown:
    case Ipopt::Insufficient_Memory:
    case Ipopt::Internal_Error:
      return QpStatus::NumericalTrouble;
  }
  return QpStatus::NumericalTrouble;
}

void set_options(Ipopt::OptionsList& list, const QpOptions& options) {
  list.SetIntegerValue("print_level", 0);
  list.SetStringValue("sb", "yes");
  list.SetIntegerValue("max_iter", options.max_iterations);
  for (const char* name : {"hessian_constant", "jac_c_constant", "jac_d_constant"}) list.SetStringValue(name, "yes");
  list.SetStringValue("nlp_scaling_method", "none");
  list.SetNumericValue("bound_relax_factor", 0.0);  // otherwise every bound gives way by 1e-8
  list.SetNumericValue("diverging_iterates_tol", 1e12);
  list.SetIntegerValue("acceptable_iter", 0);  // its acceptable points may be far from acceptable
  for (const char* name : {"tol", "constr_viol_tol", "dual_inf_tol", "compl_inf_tol"})
    list.SetNumericValue(name, ipopt_tolerance);
}

Ipopt::ApplicationReturnStatus run_ipopt(const Ipopt::SmartPtr<QpNlp>& nlp, const QpOptions& options, int& iterations) {
  const OneThread guard;
  Ipopt::SmartPtr<Ipopt::IpoptApplication> application = new Ipopt::IpoptApplication(false);
  set_options(*application->Options(), options);
  const std::string no_options_file;
  if (application->Initialize(no_options_file) != Ipopt::Solve_Succeeded) return Ipopt::Internal_Error;
  const Ipopt::ApplicationReturnStatus status = application->OptimizeTNLP(GetRawPtr(nlp));
  if (IsValid(application->Statistics())) iterations = application->Statistics()->IterationCount();
  return status;
}

QpResult IpoptSolver::solve(const QpProblem& problem, const QpOptions& options, std::span<const char> guess) {
  require_valid(problem, options, guess);
  if (std::optional<QpResult> rest = solve_at_rest(problem)) return *std::move(rest);
  const ScaledQp qp(problem);
  if (qp.conflict) {
    QpResult result;
    result.status = QpStatus::Infeasible;
    result.message = "the equalities contradict each other";
    return result;
  }
  const Ipopt::SmartPtr<QpNlp> nlp = new QpNlp(qp);
  int iterations = 0;
  Ipopt::ApplicationReturnStatus code = Ipopt::Internal_Error;
  try {
    code = run_ipopt(nlp, options, iterations);
  } catch (const std::exception&) {
    code = Ipopt::NonIpopt_Exception_Thrown;
  } catch (const Ipopt::IpoptException&) {
    code = Ipopt::Unrecoverable_Exception;
  }
  QpResult result;
  const bool has_point = nlp->y.size() == qp.f.size() && nlp->y.allFinite() && nlp->lambda.allFinite();
  if (has_point) {
    result = read_out(problem, qp, nlp->y, nlp->lambda);
    VecX y = nlp->y, lambda = nlp->lambda;
    if (polish(qp, y, lambda)) {
      QpResult polished = read_out(problem, qp, y, lambda);
      if (polished.kkt_residual <= std::max(result.kkt_residual, rounding_share)) result = std::move(polished);
    }
  }
  result.iterations = iterations;
  result.status = to_status(code);
  // The residual has the last word: it does not matter why Ipopt stopped at a solution.
  if (has_point && result.kkt_residual <= options.tolerance) result.status = QpStatus::Solved;
  if (result.status == QpStatus::Solved && !(result.kkt_residual <= options.tolerance))
    result.status = QpStatus::NumericalTrouble;
  if (result.status == QpStatus::Solved) return result;
  result.message = "Ipopt stopped with code " + std::to_string(static_cast<int>(code));
  if (result.status != QpStatus::IterationLimit) result.q.resize(0);
  return result;
}

}  // namespace

std::unique_ptr<QpSolver> make_ipopt_solver() {
  return std::make_unique<IpoptSolver>();
}

}  // namespace crease
