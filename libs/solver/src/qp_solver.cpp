// SPDX-License-Identifier: MIT
#include "crease/solver/qp_solver.hpp"

#include "active_set.hpp"
#include "ipopt.hpp"

namespace crease {

std::unique_ptr<QpSolver> make_qp_solver(QpMethod method) {
  switch (method) {
    case QpMethod::ActiveSet:
      return std::make_unique<ActiveSetSolver>();
    case QpMethod::Ipopt:
      return make_ipopt_solver();
  }
  return nullptr;
}

}  // namespace crease
