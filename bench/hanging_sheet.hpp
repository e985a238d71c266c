// SPDX-License-Identifier: MIT
#pragma once

// The matrix of one implicit step of a sheet that hangs over a table's edge.

#include <algorithm>
#include <cmath>
#include <vector>

#include "crease/dynamics/assemble.hpp"
#include "crease/geometry/grid.hpp"
#include "measure.hpp"

namespace crease {

struct HangingSheet {
  static constexpr double h = 0.005;  ///< [s]

  Cloth cloth;
  DofMap dofs;
  Material material;
  SparseMatrix H;
  BlockGraph graph;
  double lift = 0;         ///< on the diagonal: the sheet is flat enough for EOL unknowns to be undecided
  std::vector<char> held;  ///< contacts of the third on the table, material motion along the edge
  int n_faces = 0, n_eol = 0, n_held = 0;
};

/// @param cells  along each side of the square; two triangles each
inline HangingSheet make_hanging_sheet(int cells) {
  GridOptions grid;
  grid.cells = {cells, cells};
  grid.pattern = GridPattern::Irregular;
  HangingSheet sheet;
  sheet.cloth = make_cloth(make_grid(grid));
  Cloth& cloth = sheet.cloth;
  const double spacing = 1.0 / cells, edge = 2.0 / 3;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    const Vec2& X = cloth.mesh.X[v];
    const double over = std::max(0.0, edge - X.x());
    cloth.mesh.x[v] = Vec3(edge - 0.6 * over, X.y() + 0.01 * std::sin(9 * X.x()), -0.8 * over);
    if (X.x() >= edge) cloth.mesh.x[v] = Vec3(X.x(), X.y(), 0);
    const bool inside = X.y() > 0.5 * spacing && X.y() < 1 - 0.5 * spacing;
    if (inside && std::abs(X.x() - edge) < 0.5 * spacing) cloth.feature[v].kind = FeatureKind::Edge;
  }
  sheet.dofs = make_dof_map(cloth);
  const DofMap& dofs = sheet.dofs;
  Assembler assembler;
  sheet.H = assembler.assemble(cloth, dofs, sheet.material, {}, HangingSheet::h, false).H;
  sheet.graph = graph_of(sheet.H, dofs.start);
  sheet.lift = 1e-6 * sheet.H.diagonal().maxCoeff();
  sheet.n_faces = cloth.mesh.n_faces();
  sheet.held.assign(static_cast<std::size_t>(dofs.size()), 0);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    if (cloth.mesh.X[v].x() >= edge || dofs.is_eol(v)) sheet.held[dofs.x(v) + 2] = 1;
    if (dofs.is_eol(v)) sheet.held[dofs.X(v) + 1] = 1;
    sheet.n_eol += dofs.is_eol(v);
  }
  sheet.n_held = static_cast<int>(std::count(sheet.held.begin(), sheet.held.end(), 1));
  return sheet;
}

}  // namespace crease
