// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "crease/geometry/cloth.hpp"

namespace crease {

/// EOL vertices that no step may take where they would go.
struct Runaways {
  std::vector<int> too_far;     ///< at triangles that lose more of their material area than they may
  std::vector<int> at_needles;  ///< at needles that get thinner
};

/// @pre `before` and `after` share a compact mesh but for the places of its vertices
Runaways find_runaways(const Cloth& before, const Cloth& after);

}  // namespace crease
