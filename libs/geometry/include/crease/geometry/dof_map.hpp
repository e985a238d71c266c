// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "crease/base/types.hpp"
#include "crease/geometry/cloth.hpp"

namespace crease {

/// Where each vertex' unknowns stand in the vector qdot: xdot (3) and, for EOL vertices, Xdot (2) right behind it.
/// Vertices that are tied by a seam are one point of the cloth: the lowest of them owns its unknowns, which all share.
/// So a seam stays closed to the last bit, with three unknowns and no constraint.
struct DofMap {
  std::vector<int> start;   ///< n_vertices + 1 entries; vertex i owns [start[i], start[i+1]), maybe nothing
  std::vector<int> owners;  ///< whose unknowns a vertex has; empty where all own theirs: no seams
  int size() const { return start.back(); }
  int owner(int vertex) const { return owners.empty() ? vertex : owners[vertex]; }
  int x(int vertex) const { return start[owner(vertex)]; }
  int X(int vertex) const { return x(vertex) + 3; }
  bool is_eol(int vertex) const { return start[vertex + 1] - start[vertex] == 5; }
};

/// @pre cloth.mesh.is_compact()
DofMap make_dof_map(const Cloth& cloth);

/// The starts of those vertices that own unknowns, and the end: strictly ascending.
std::vector<int> dof_blocks(const DofMap& dofs);

/// qdot gathered from / scattered to cloth.v and cloth.V.
VecX gather_velocity(const Cloth& cloth, const DofMap& dofs);
void scatter_velocity(const VecX& qdot, const DofMap& dofs, Cloth& cloth);

}  // namespace crease
