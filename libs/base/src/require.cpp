// SPDX-License-Identifier: MIT
#include "crease/base/require.hpp"

#include <stdexcept>
#include <string>

namespace crease {

void require(bool condition, std::string_view message) {
  if (!condition) throw std::invalid_argument(std::string(message));
}

}  // namespace crease
