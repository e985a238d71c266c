// SPDX-License-Identifier: MIT
#pragma once

#include "crease/remesh/remesh.hpp"

namespace crease {

/// Throws std::invalid_argument naming the option that is missing or out of range.
void require_valid(const AdaptOptions& options);
void require_valid(const ConformOptions& options);

}  // namespace crease
