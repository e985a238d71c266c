// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "crease/solver/block_cholesky.hpp"

namespace crease {

/// Same graph, same order.
std::vector<int> minimum_degree_order(const BlockGraph& graph);

/// The given order, or where that is empty the one that analyze() promises.
std::vector<int> choose_order(const BlockGraph& graph, std::span<const int> given);

}  // namespace crease
