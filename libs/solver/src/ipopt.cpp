// SPDX-License-Identifier: MIT
// The only file that calls Ipopt [WAECHTER06].
#include "ipopt.hpp"

#include <IpIpoptApplication.hpp>
#include <IpSolveStatistics.hpp>
#include <IpTNLP.hpp>
#include <algorithm>
#include <cmath>
#include <limits>

#include "entry.hpp"
#include "one_thread.hpp"
#include "scaled_qp.hpp"

namespace crease {
namespace {

constexpr double no_bound = 2e19;  ///< Ipopt takes 1e19 and more for no bound

/// Asked of Ipopt, on the scaled problem.
constexpr double ipopt_tolerance = 1e-11;
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

class IpoptSolver : public QpSolver {
 public:
  QpResult solve(const QpProblem& problem, const QpOptions& options, std::span<const char> guess) override;
};

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
  if (std::optional<QpResult> refused = qp.refusal()) return *std::move(refused);
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
  if (has_point) result = qp.read_out(problem, nlp->y, nlp->lambda);
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
