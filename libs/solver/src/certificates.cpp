// SPDX-License-Identifier: MIT
#include "certificates.hpp"

#include <algorithm>
#include <cmath>

#include "max_abs.hpp"

namespace crease {
namespace {

/// How many times larger than the iterate a feasible point would have to be.
constexpr double out_of_proportion = 1e4;
/// A product with the ray, relative to what its terms could add up to, that counts as zero.
constexpr double zero_share = 1e-9;
/// |cosine| between f and the ray that is surely not rounding.
constexpr double pull_share = 1e-7;

}  // namespace

bool proves_infeasible(const QpProblem& problem, const VecX& ray_eq, VecX ray_in, const VecX& q) {
  ray_in = ray_in.cwiseMax(0.0);
  const double gain = problem.b_eq.dot(ray_eq) + problem.b_in.dot(ray_in);
  const double terms = problem.b_eq.cwiseAbs().dot(ray_eq.cwiseAbs()) + problem.b_in.cwiseAbs().dot(ray_in);
  if (!(gain > zero_share * terms)) return false;
  VecX rest = VecX::Zero(problem.f.size());
  if (ray_eq.size() > 0) rest += problem.A_eq.transpose() * ray_eq;
  if (ray_in.size() > 0) rest += problem.A_in.transpose() * ray_in;
  return rest.lpNorm<1>() * max_abs(q) * out_of_proportion <= gain;
}

bool proves_unbounded(const QpProblem& problem, const VecX& ray) {
  const double size = max_abs(ray);
  if (!(size > 0) || !std::isfinite(size)) return false;
  const VecX d = ray / size;
  if (!(problem.f.dot(d) > pull_share * problem.f.norm() * d.norm())) return false;
  const double stiffest = problem.H.nonZeros() == 0 ? 0.0 : problem.H.coeffs().abs().maxCoeff();
  if (max_abs(problem.H * d) > zero_share * stiffest) return false;
  const auto holds = [&](const SparseRows& A, bool equality) {
    for (int i = 0; i < A.rows(); ++i) {
      double value = 0, terms = 0;
      for (SparseRows::InnerIterator a(A, i); a; ++a) value += a.value() * d[a.col()], terms += std::abs(a.value());
      if (value < -zero_share * terms || (equality && value > zero_share * terms)) return false;
    }
    return true;
  };
  return holds(problem.A_eq, true) && holds(problem.A_in, false);
}

}  // namespace crease
