// SPDX-License-Identifier: MIT
#include "crease/geometry/dof_map.hpp"

#include <algorithm>

#include "crease/base/require.hpp"

namespace crease {

DofMap make_dof_map(const Cloth& cloth) {
  require(cloth.mesh.is_compact(), "make_dof_map: expected a compact mesh");
  DofMap dofs;
  dofs.start.reserve(static_cast<std::size_t>(cloth.mesh.n_vertices()) + 1);
  dofs.start.push_back(0);
  const Mesh& mesh = cloth.mesh;
  if (mesh.has_seams()) {
    dofs.owners.assign(mesh.X.size(), Mesh::none);
    for (int i = 0; i < mesh.n_vertices(); ++i)
      for (int v = i; dofs.owners[v] == Mesh::none; v = mesh.tied(v)) dofs.owners[v] = i;
  }
  for (int i = 0; i < mesh.n_vertices(); ++i) {
    const int n = dofs.owner(i) != i ? 0 : cloth.is_eol(i) ? 5 : 3;
    dofs.start.push_back(dofs.start.back() + n);
  }
  return dofs;
}

std::vector<int> dof_blocks(const DofMap& dofs) {
  std::vector<int> blocks = dofs.start;
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  return blocks;
}

VecX gather_velocity(const Cloth& cloth, const DofMap& dofs) {
  require(dofs.start.size() == cloth.v.size() + 1, "gather_velocity: expected a map of this cloth");
  VecX qdot(dofs.size());
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
    qdot.segment<3>(dofs.x(i)) = cloth.v[i];
    if (dofs.is_eol(i)) qdot.segment<2>(dofs.X(i)) = cloth.V[i];
  }
  return qdot;
}

void scatter_velocity(const VecX& qdot, const DofMap& dofs, Cloth& cloth) {
  require(dofs.start.size() == cloth.v.size() + 1, "scatter_velocity: expected a map of this cloth");
  require(qdot.size() == dofs.size(), "scatter_velocity: expected one number an unknown");
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
    cloth.v[i] = qdot.segment<3>(dofs.x(i));
    cloth.V[i] = dofs.is_eol(i) ? Vec2(qdot.segment<2>(dofs.X(i))) : Vec2(Vec2::Zero());
  }
}

}  // namespace crease
