// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "crease/remesh/remesh.hpp"
#include "sliding_sheet.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

AdaptOptions wide_options() {
  AdaptOptions options;
  options.size = {1e-3, 10};
  options.aspect = 1e-3;
  return options;
}

GridOptions unit_grid(int cells, GridPattern pattern = GridPattern::Irregular) {
  GridOptions grid;
  grid.cells = {cells, cells};
  grid.pattern = pattern;
  return grid;
}

// Edge wanted at the vertex nearest to the middle, along a unit direction.
double length_wanted(const Cloth& cloth, const std::vector<Mat2>& sizes, const Vec2& direction) {
  int middle = 0;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
    if ((cloth.mesh.X[v] - Vec2(0.5, 0.5)).norm() < (cloth.mesh.X[middle] - Vec2(0.5, 0.5)).norm()) middle = v;
  return 1 / std::sqrt(direction.dot(sizes[middle] * direction));
}

// On a cylinder of radius R an arc of length R angle turns the normal by the angle allowed.
TEST(Sizing, ResolvesACylinderAcrossAndNotAlong) {
  Cloth cloth = make_cloth(make_grid(unit_grid(40)));
  const double R = 0.5;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    const Vec2& X = cloth.mesh.X[v];
    cloth.mesh.x[v] = Vec3(R * std::sin(X.x() / R), X.y(), R * std::cos(X.x() / R));
  }
  AdaptOptions options = wide_options();
  options.compression = 1e3;
  const auto sizes = sizing_field(cloth, options);
  // Dihedral angles on an irregular mesh scatter about the curvature, and the larger of the two estimates counts.
  EXPECT_NEAR(length_wanted(cloth, sizes, Vec2(1, 0)), options.angle * R, 0.35 * options.angle * R);
  EXPECT_GT(length_wanted(cloth, sizes, Vec2(0, 1)), 1.5 * options.angle * R);
}

// A buckle that takes up the compression eps with an amplitude of c is c / sqrt(eps) long; E = F^T F - I is twice that.
TEST(Sizing, ResolvesTheBucklesOfACompressedSheet) {
  Cloth cloth = make_cloth(make_grid(unit_grid(10)));
  const double lambda = 0.98;
  for (Vec3& x : cloth.mesh.x) x.x() *= lambda;
  const AdaptOptions options = wide_options();
  const auto sizes = sizing_field(cloth, options);
  EXPECT_NEAR(length_wanted(cloth, sizes, Vec2(1, 0)), options.compression / std::sqrt(1 - lambda * lambda), 1e-9);
}

TEST(Sizing, ResolvesAVelocityGradientButNoRotation) {
  Cloth cloth = make_cloth(make_grid(unit_grid(10)));
  const AdaptOptions options = wide_options();
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) cloth.v[v] = Vec3(4 * cloth.mesh.X[v].x(), 0, 0);
  EXPECT_NEAR(length_wanted(cloth, sizing_field(cloth, options), Vec2(1, 0)), options.velocity / 4, 1e-9);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) cloth.v[v] = Vec3(10, -20, 30).cross(cloth.mesh.x[v]);
  EXPECT_NEAR(length_wanted(cloth, sizing_field(cloth, options), Vec2(1, 0)), options.size[1], 1e-6);
}

TEST(Sizing, KeepsToItsLimits) {
  support::Rng rng(9);
  Cloth cloth = make_cloth(make_grid(unit_grid(12)));
  support::crumple(cloth.mesh, rng, 0.05);
  AdaptOptions options;
  options.size = {0.02, 0.2};
  for (const Mat2& M : sizing_field(cloth, options)) {
    const Vec2 l = Eigen::SelfAdjointEigenSolver<Mat2>(M).eigenvalues();
    EXPECT_GE(l[0], 1 / (0.2 * 0.2) * (1 - 1e-9));
    EXPECT_LE(l[1], 1 / (0.02 * 0.02) * (1 + 1e-9));
    EXPECT_GE(l[0], options.aspect * options.aspect * l[1] * (1 - 1e-9));
  }
}

// The sizes of neighbours differ by no more than the gradation of 1.4 allows, with the metric's own length of the edge.
TEST(Sizing, GrowsNoFasterThanTheGradation) {
  Cloth cloth = make_cloth(make_grid(unit_grid(20)));
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    const Vec2 d = cloth.mesh.X[v] - Vec2(0.5, 0.5);
    cloth.mesh.x[v].z() = d.norm() < 0.05 ? 0.03 : 0;
  }
  AdaptOptions options;
  options.size = {0.01, 0.5};
  options.aspect = 1;
  const auto sizes = sizing_field(cloth, options);
  for (const int h : cloth.mesh.edges()) {
    const int a = cloth.mesh.from(h), b = cloth.mesh.to(h);
    const Vec2 e = cloth.mesh.X[b] - cloth.mesh.X[a];
    for (const auto& [M, N] : {std::pair{sizes[a], sizes[b]}, std::pair{sizes[b], sizes[a]}}) {
      const double growth = 1 + std::sqrt(e.dot(M * e)) * std::log(1.4);
      EXPECT_GE(N(0, 0), M(0, 0) / (growth * growth) * (1 - 1e-3));
    }
  }
}

// A right angle over the table's edge is the chain's business; without the chain it asks for the finest mesh.
TEST(Sizing, DoesNotLookAcrossAChain) {
  support::SlidingSheet sheet({.pattern = GridPattern::Irregular, .place = 0.513});
  sheet.cloth = sheet.conform({}).cloth;
  sheet.bend(-std::numbers::pi / 2);
  AdaptOptions options;
  options.size = {0.01, 0.2};
  for (const Mat2& M : sizing_field(sheet.cloth, options)) EXPECT_NEAR(M.trace(), 2 / (0.2 * 0.2), 1e-6);
  for (int v = 0; v < sheet.cloth.mesh.n_vertices(); ++v)
    if (sheet.cloth.is_eol(v)) make_lagrangian(sheet.cloth, v);
  double largest = 0;
  for (const Mat2& M : sizing_field(sheet.cloth, options)) largest = std::max(largest, M.trace());
  EXPECT_GT(largest, 0.5 / (0.01 * 0.01));
}

TEST(Sizing, IgnoresWhatIsNotFinite) {
  Cloth cloth = make_cloth(make_grid(unit_grid(6)));
  cloth.v[10] = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  AdaptOptions options;
  options.size = {0.02, 0.2};
  for (const Mat2& M : sizing_field(cloth, options)) EXPECT_TRUE(M.allFinite());
}

}  // namespace
}  // namespace crease
