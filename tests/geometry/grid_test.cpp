// SPDX-License-Identifier: MIT
#include "crease/geometry/grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "support/meshes.hpp"

namespace crease {
namespace {

constexpr std::array patterns = {GridPattern::Cross, GridPattern::Alternating, GridPattern::Right,
                                 GridPattern::Irregular};

GridOptions options_for(GridPattern pattern) {
  GridOptions options;
  options.size = Vec2(0.7, 1.3);
  options.cells = {7, 11};
  options.pattern = pattern;
  return options;
}

TEST(Grid, CoversTheRectangleOnce) {
  for (const GridPattern pattern : patterns) {
    SCOPED_TRACE(static_cast<int>(pattern));
    const Mesh mesh = make_grid(options_for(pattern));
    EXPECT_EQ(mesh.validate(), std::nullopt);
    EXPECT_NEAR(support::total_area(mesh), 0.7 * 1.3, 1e-14);
    EXPECT_EQ(support::euler_characteristic(mesh), 1);
  }
}

TEST(Grid, HasTheFacesOfItsPattern) {
  const int n = 7, m = 11;
  EXPECT_EQ(make_grid(options_for(GridPattern::Cross)).n_faces(), 4 * n * m);
  EXPECT_EQ(make_grid(options_for(GridPattern::Cross)).n_vertices(), (n + 1) * (m + 1) + n * m);
  for (const GridPattern pattern : {GridPattern::Alternating, GridPattern::Right, GridPattern::Irregular}) {
    EXPECT_EQ(make_grid(options_for(pattern)).n_faces(), 2 * n * m);
    EXPECT_EQ(make_grid(options_for(pattern)).n_vertices(), (n + 1) * (m + 1));
  }
}

TEST(Grid, AlternatesItsDiagonals) {
  // Inside an alternating grid vertices have 4 or 8 neighbours in turn; with one diagonal all have 6.
  for (const GridPattern pattern : {GridPattern::Alternating, GridPattern::Right}) {
    const Mesh mesh = make_grid(options_for(pattern));
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      if (mesh.is_border_vertex(v)) continue;
      const int i = v % 8, j = v / 8;
      const std::size_t expected = pattern == GridPattern::Right ? 6 : ((i + j) % 2 == 0 ? 8 : 4);
      EXPECT_EQ(mesh.neighbours(v).size(), expected);
    }
  }
}

TEST(Grid, KeepsBorderStraightAndCorners) {
  for (const GridPattern pattern : patterns) {
    SCOPED_TRACE(static_cast<int>(pattern));
    const Mesh mesh = make_grid(options_for(pattern));
    int corners = 0;
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      const Vec2& P = mesh.X[v];
      const bool side_x = P.x() == 0 || P.x() == 0.7, side_y = P.y() == 0 || P.y() == 1.3;
      EXPECT_EQ(mesh.is_border_vertex(v), side_x || side_y);
      EXPECT_EQ(mesh.is_material_corner(v), side_x && side_y);
      corners += side_x && side_y ? 1 : 0;
    }
    EXPECT_EQ(corners, 4);
  }
}

TEST(Grid, MapsMaterialToWorldByItsAxes) {
  GridOptions options = options_for(GridPattern::Irregular);
  options.origin = Vec3(1, 2, 3);
  options.u = Vec3(0, 0, 1);
  options.v = Vec3(0, 2, 0);
  const Mesh mesh = make_grid(options);
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    EXPECT_EQ(mesh.x[v], Vec3(1, 2 + 2 * mesh.X[v].y(), 3 + mesh.X[v].x()));
  }
}

TEST(IrregularGrid, IsDelaunay) {
  const Mesh mesh = support::grid(GridPattern::Irregular, 12, 9, 3);
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const auto P = material_corners(mesh, f);
    // Circumcentre c: 2 (P_i - P_0) . c = |P_i|^2 - |P_0|^2.
    const Vec2 a = P[1] - P[0], b = P[2] - P[0];
    const double d = 2 * (a.x() * b.y() - a.y() * b.x());
    const Vec2 c =
        Vec2(b.y() * a.squaredNorm() - a.y() * b.squaredNorm(), a.x() * b.squaredNorm() - b.x() * a.squaredNorm()) / d;
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      EXPECT_GT((mesh.X[v] - P[0] - c).norm(), c.norm() * (1 - 1e-10));  // circumcentres of needles lose digits
    }
  }
}

TEST(IrregularGrid, HasNoNeedles) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    const int n = seed % 10 == 0 ? 40 : 5 + static_cast<int>(seed % 7);
    const Mesh mesh = support::grid(GridPattern::Irregular, n, n, seed);
    double smallest = std::numeric_limits<double>::infinity();
    for (int f = 0; f < mesh.n_faces(); ++f) smallest = std::min(smallest, smallest_angle(material_corners(mesh, f)));
    EXPECT_GT(smallest, 20 * std::numbers::pi / 180);
  }
}

TEST(IrregularGrid, IsTheSameForTheSameSeedOnly) {
  const Mesh a = support::grid(GridPattern::Irregular, 6, 5, 8), b = support::grid(GridPattern::Irregular, 6, 5, 8);
  const Mesh c = support::grid(GridPattern::Irregular, 6, 5, 9);
  EXPECT_EQ(a.X, b.X);
  EXPECT_NE(a.X, c.X);
  for (int f = 0; f < a.n_faces(); ++f) EXPECT_EQ(a.face(f), b.face(f));
}

TEST(IrregularGrid, DrawsSplitMix64Numbers) {
  // The published sequence of seed 1234567 begins 6457827717110365317, 3203168211198807973, 9817491932198370423; two
  // numbers go to each point, so the third moves the second point of the bottom row.
  GridOptions options;
  options.cells = {4, 4};
  options.pattern = GridPattern::Irregular;
  options.seed = 1234567;
  const double unit = 9817491932198370423.0 / 0x1p64;  // in [0, 1)
  EXPECT_NEAR(make_grid(options).X[1].x(), 0.25 + 0.2 * 0.25 * (2 * unit - 1), 1e-16);
}

TEST(Grid, RefusesWhatIsNoRectangle) {
  GridOptions options;
  options.cells = {0, 3};
  EXPECT_THROW(make_grid(options), std::invalid_argument);
  options.cells = {3, 3};
  options.size = Vec2(1, -1);
  EXPECT_THROW(make_grid(options), std::invalid_argument);
  options.size = Vec2(1, std::numeric_limits<double>::infinity());
  EXPECT_THROW(make_grid(options), std::invalid_argument);
}

}  // namespace
}  // namespace crease
