// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "crease/base/types.hpp"
#include "crease/geometry/cloth.hpp"

namespace crease {

/// Where each vertex' unknowns stand in the vector qdot: xdot (3) and, for EOL vertices, Xdot (2) right behind it.
struct DofMap {
  std::vector<int> start;  ///< n_vertices + 1 entries; vertex i owns [start[i], start[i+1])
  int size() const { return start.back(); }
  int x(int vertex) const { return start[vertex]; }
  int X(int vertex) const { return start[vertex] + 3; }
  bool is_eol(int vertex) const { return start[vertex + 1] - start[vertex] == 5; }
};

/// @pre cloth.mesh.is_compact()
DofMap make_dof_map(const Cloth& cloth);

/// qdot gathered from / scattered to cloth.v and cloth.V.
VecX gather_velocity(const Cloth& cloth, const DofMap& dofs);
void scatter_velocity(const VecX& qdot, const DofMap& dofs, Cloth& cloth);

}  // namespace crease
