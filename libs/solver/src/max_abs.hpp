// SPDX-License-Identifier: MIT
#pragma once

#include "crease/base/types.hpp"

namespace crease {

/// Largest size of an entry; 0 if there is none.
template <class Vector>
double max_abs(const Eigen::MatrixBase<Vector>& v) {
  return v.size() == 0 ? 0.0 : v.cwiseAbs().maxCoeff();
}

}  // namespace crease
