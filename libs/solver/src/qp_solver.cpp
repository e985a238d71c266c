// SPDX-License-Identifier: MIT
#include "crease/solver/qp_solver.hpp"

#include "active_set.hpp"
#include "interior_point.hpp"
#include "ipopt.hpp"

namespace crease {

std::unique_ptr<QpSolver> make_qp_solver(QpMethod method, int threads) {
  switch (method) {
    case QpMethod::ActiveSet:
      return std::make_unique<ActiveSetSolver>(threads);
    case QpMethod::InteriorPoint:
      return make_interior_point_solver();
    case QpMethod::Ipopt:
      return make_ipopt_solver();
  }
  return nullptr;
}

}  // namespace crease
