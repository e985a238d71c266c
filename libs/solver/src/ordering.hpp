// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "crease/solver/block_cholesky.hpp"

namespace crease {

/// Elimination order of the blocks by approximate minimum degree [AMESTOY96]; empty if out of memory.
std::vector<int> minimum_degree_order(const BlockGraph& graph);

}  // namespace crease
