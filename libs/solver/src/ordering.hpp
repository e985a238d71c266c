// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "crease/solver/block_cholesky.hpp"

namespace crease {

/// The given order, or where that is empty one of approximate minimum degree [AMESTOY96]. Nothing if out of memory.
std::optional<std::vector<int>> choose_order(const BlockGraph& graph, std::span<const int> given);

}  // namespace crease
