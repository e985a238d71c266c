// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

#include <gtest/gtest.h>

#include "crease/geometry/grid.hpp"
#include "crease/geometry/triangle.hpp"
#include "crease/remesh/remesh.hpp"

namespace crease {
namespace {

constexpr double degree = 0.017453292519943295;

double share_of_good_angles(const Mesh& mesh, double& sharpest) {
  int n_good = 0;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const auto X = material_corners(mesh, f);
    sharpest = std::min(sharpest, smallest_angle(X));
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 a = X[(k + 1) % 3] - X[k], b = X[(k + 2) % 3] - X[k];
      const double angle = std::acos(a.dot(b) / (a.norm() * b.norm()));
      n_good += angle >= (30 - 1e-9) * degree && angle <= (120 + 1e-9) * degree ? 1 : 0;
    }
  }
  return n_good / (3.0 * mesh.n_faces());
}

// One constant size, from every grid: all lengths between 1/2 and 1 of it. (Sheets of a dozen faces have no 95 % of
// angles.)
TEST(AdaptBand, HoldsAllLengthsFromAnyGrid) {
  int n_meshes = 0, n_edges = 0;
  double shortest = 1, sharpest = 180 * degree, fewest_good = 1;
  for (const Vec2& sheet : {Vec2(1, 1), Vec2(1.3, 0.7)})
    for (const double size : {0.043, 0.05, 0.06, 0.067, 0.0777, 0.083, 0.1, 0.125, 0.15, 0.2})
      for (const GridPattern pattern :
           {GridPattern::Cross, GridPattern::Alternating, GridPattern::Right, GridPattern::Irregular})
        for (const int cells : {1, 2, 3, 5, 7, 10, 13, 16, 20, 22, 25, 28, 40, 52, 60, 100}) {
          SCOPED_TRACE("size " + std::to_string(size) + ", pattern " + std::to_string(static_cast<int>(pattern)) +
                       ", cells " + std::to_string(cells));
          GridOptions grid;
          grid.size = sheet;
          grid.cells = {cells, static_cast<int>(std::ceil(cells * sheet.y() / sheet.x()))};
          grid.pattern = pattern;
          AdaptOptions options;
          options.size = {size, size};
          const RemeshResult result = adapt(make_cloth(make_grid(grid)), options);
          const Mesh& mesh = result.cloth.mesh;
          ASSERT_EQ(validate(result.cloth), std::nullopt);
          const std::vector<int> edges = mesh.edges();
          for (const int h : edges) {
            const double L = mesh.material_length(h) / size;
            shortest = std::min(shortest, L);
            EXPECT_LE(L, 1 + 1e-12);
            EXPECT_GE(L, 0.5 * (1 - 1e-9));  // the halves of an edge of length 1 may stay
          }
          fewest_good = std::min(fewest_good, share_of_good_angles(mesh, sharpest));
          EXPECT_FALSE(adapt(result.cloth, options).report.changed);
          ++n_meshes, n_edges += static_cast<int>(edges.size());
        }
  std::cout << n_meshes << " meshes, " << n_edges << " edges, the shortest " << shortest << "; smallest angle "
            << sharpest / degree << " degrees, in [30, 120] at least " << 100 * fewest_good << " %\n";
  EXPECT_GE(fewest_good, 0.95);
  EXPECT_GE(sharpest, 15 * degree);
}

}  // namespace
}  // namespace crease
