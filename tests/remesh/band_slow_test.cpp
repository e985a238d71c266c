// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "crease/geometry/grid.hpp"
#include "crease/geometry/triangle.hpp"
#include "crease/remesh/remesh.hpp"

namespace crease {
namespace {

// What one constant size makes of every grid: how many lengths lie between 1/2 and 1 of it, and which angles there are.
TEST(AdaptBand, HoldsNearlyAllLengthsFromAnyGrid) {
  constexpr double degree = 0.017453292519943295;
  int n_meshes = 0, n_full = 0, n_edges = 0, n_short = 0;
  double shortest = 1, sharpest = 180 * degree;
  for (const double size : {0.06, 0.1, 0.05, 0.0777})
    for (const GridPattern pattern :
         {GridPattern::Cross, GridPattern::Alternating, GridPattern::Right, GridPattern::Irregular})
      for (const int cells : {1, 2, 3, 5, 7, 10, 13, 20, 28, 40, 60, 100}) {
        SCOPED_TRACE("size " + std::to_string(size) + ", pattern " + std::to_string(static_cast<int>(pattern)) +
                     ", cells " + std::to_string(cells));
        GridOptions grid;
        grid.cells = {cells, cells};
        grid.pattern = pattern;
        AdaptOptions options;
        options.size = {size, size};
        const RemeshResult result = adapt(make_cloth(make_grid(grid)), options);
        const Mesh& mesh = result.cloth.mesh;
        ASSERT_EQ(validate(result.cloth), std::nullopt);
        int n_here = 0, n_good = 0;
        for (const int h : mesh.edges()) {
          const double L = mesh.material_length(h) / size;
          shortest = std::min(shortest, L);
          EXPECT_LE(L, 1 + 1e-12);
          n_here += L < 0.5 * (1 - 1e-9) ? 1 : 0;
        }
        for (int f = 0; f < mesh.n_faces(); ++f) {
          const auto X = material_corners(mesh, f);
          sharpest = std::min(sharpest, smallest_angle(X));
          for (std::size_t k = 0; k < 3; ++k) {
            const Vec2 a = X[(k + 1) % 3] - X[k], b = X[(k + 2) % 3] - X[k];
            const double angle = std::acos(a.dot(b) / (a.norm() * b.norm()));
            n_good += angle >= (30 - 1e-9) * degree && angle <= (120 + 1e-9) * degree ? 1 : 0;
          }
        }
        const int n = static_cast<int>(mesh.edges().size());
        EXPECT_LE(n_here, 0.005 * n);
        EXPECT_GE(n_good, 0.95 * 3 * mesh.n_faces());
        EXPECT_FALSE(adapt(result.cloth, options).report.changed);
        ++n_meshes, n_full += n_here == 0 ? 1 : 0, n_edges += n, n_short += n_here;
      }
  std::cout << n_full << " of " << n_meshes << " meshes have no length below 1/2; " << n_short << " of " << n_edges
            << " edges have, " << shortest << " the shortest; smallest angle " << sharpest / degree << " degrees\n";
  EXPECT_GE(n_full, 9 * n_meshes / 10);
  EXPECT_GE(sharpest, 15 * degree);
}

}  // namespace
}  // namespace crease
