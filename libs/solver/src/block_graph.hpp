// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "crease/solver/block_cholesky.hpp"

namespace crease {

/// Throws std::invalid_argument on a malformed graph, or on an order that is neither empty nor a permutation of its
/// blocks.
void require_valid(const BlockGraph& graph, std::span<const int> order);

}  // namespace crease
