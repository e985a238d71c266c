// SPDX-License-Identifier: MIT
#pragma once

#include "crease/solver/block_cholesky.hpp"
#include "front_kernels.hpp"

namespace crease {

/// Throws std::invalid_argument if this processor does not run them.
const FrontKernels& find_front_kernels(FrontKernelSet set);

}  // namespace crease
