// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <string_view>

namespace crease {

/// Throws std::invalid_argument with `message` ("where: expected ..., got ...") unless `condition` holds.
/// For documented preconditions of public entry points, once per call; kernels only assert.
void require(bool condition, std::string_view message);

}  // namespace crease

/// Our own bug if it fails; on in Debug builds only.
#define CREASE_ASSERT(condition) assert(condition)
