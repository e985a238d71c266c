// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "crease/solver/qp_solver.hpp"
#include "support/qp_problems.hpp"

namespace crease {
namespace {

using Json = nlohmann::json;

VecX to_vector(const Json& list) {
  VecX v(static_cast<Eigen::Index>(list.size()));
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = list[static_cast<size_t>(i)].get<double>();
  return v;
}

MatX to_matrix(const Json& list) {
  MatX A(static_cast<Eigen::Index>(list.size()), list.empty() ? 0 : static_cast<Eigen::Index>(list[0].size()));
  for (Eigen::Index i = 0; i < A.rows(); ++i) A.row(i) = to_vector(list[static_cast<size_t>(i)]).transpose();
  return A;
}

Json load_cases() {
  std::ifstream file(CREASE_TEST_DATA "/qp_cases.json");
  return Json::parse(file).at("cases");
}

QpProblem to_problem(const Json& c) {
  return support::dense_problem(to_matrix(c["H"]), to_vector(c["f"]), to_matrix(c["A_eq"]), to_vector(c["b_eq"]),
                                to_matrix(c["A_in"]), to_vector(c["b_in"]));
}

class CertifiedCases : public testing::TestWithParam<QpMethod> {};

TEST_P(CertifiedCases, AreSolvedOrReported) {
  const auto solver = make_qp_solver(GetParam());
  for (const Json& c : load_cases()) {
    SCOPED_TRACE(c["name"].get<std::string>());
    const QpProblem problem = to_problem(c);
    const QpResult result = solver->solve(problem);
    const std::string status = c["status"];
    if (status != "ok" && GetParam() == QpMethod::InteriorPoint) {  // tells no more than that it found nothing
      EXPECT_NE(result.status, QpStatus::Solved);
      continue;
    }
    if (status != "ok") {
      EXPECT_EQ(result.status, status == "infeasible" ? QpStatus::Infeasible : QpStatus::Unbounded) << result.message;
      EXPECT_EQ(result.q.size(), 0);
      EXPECT_FALSE(result.message.empty());
      continue;
    }
    ASSERT_EQ(result.status, QpStatus::Solved) << result.message;
    const double objective = c["objective"];
    EXPECT_NEAR(support::objective(problem, result.q), objective, 1e-6 * (1 + std::abs(objective)));
    EXPECT_LE(kkt_residual(problem, result.q, result.lambda_eq, result.lambda_in), 1e-9);
    const VecX slack = problem.A_in * result.q - problem.b_in;
    for (int i = 0; i < slack.size(); ++i) {
      EXPECT_GE(result.lambda_in[i], -1e-12);
      // The sizes of slack and multiplier in these cases are up to 10, and 1e-4 in the corner node's.
      EXPECT_LE(std::abs(slack[i] * result.lambda_in[i]), 1e-10);
    }
    // The brute-force answers carry least-squares rounding; the stiff case multiplies it by its condition, 1e10.
    const VecX q = to_vector(c["q"]);
    EXPECT_LE((result.q - q).lpNorm<Eigen::Infinity>(), 1e-5 * (1 + q.lpNorm<Eigen::Infinity>()));
    if (!c["unique_multipliers"].get<bool>()) continue;
    const VecX lambda = to_vector(c["lambda_in"]);
    for (int i = 0; i < lambda.size(); ++i)
      EXPECT_NEAR(result.lambda_in[i], lambda[i], 1e-6 * (1 + lambda.lpNorm<Eigen::Infinity>()));
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, CertifiedCases,
                         testing::Values(QpMethod::ActiveSet, QpMethod::InteriorPoint, QpMethod::Ipopt),
                         [](const auto& method) {
                           return method.param == QpMethod::Ipopt       ? "Ipopt"
                                  : method.param == QpMethod::ActiveSet ? "ActiveSet"
                                                                        : "InteriorPoint";
                         });

}  // namespace
}  // namespace crease
