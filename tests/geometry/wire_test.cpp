// SPDX-License-Identifier: MIT
#include "crease/geometry/wire.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "crease/geometry/grid.hpp"

namespace crease {
namespace {

constexpr double degrees = std::numbers::pi / 180;
constexpr int across = 4;  // cells

Vec3 unit_vector(std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  return Vec3(normal(rng), normal(rng), normal(rng)).normalized();
}

/// A sheet with a fold along U = 0.5 that turns it by `bend` on each side of the fold, away from -z where it is
/// positive; the vertices of the fold ride on a wire with `side`.
Cloth folded_sheet(double bend, int side) {
  Cloth cloth = make_cloth(make_grid({.size = {1, 1}, .cells = {across, across}, .pattern = GridPattern::Right}));
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    const Vec2& X = cloth.mesh.X[v];
    const double u = X.x() - 0.5;
    cloth.mesh.x[v] = {u * std::cos(bend), X.y(), -std::abs(u) * std::sin(bend)};
    if (std::abs(u) < 1e-9) {
      cloth.feature[v] = {0, FeatureKind::Edge, 0, side};
      cloth.mesh.x[v].x() = 0;
    }
  }
  EXPECT_EQ(cloth.n_eol(), across + 1);
  return cloth;
}

TEST(MakeWire, HasASegmentBetweenPointsAndACornerAtJoints) {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {1, 2, 3}};
  const ObstacleShape wire = make_wire(points);
  ASSERT_EQ(wire.edges.size(), 3u);
  ASSERT_EQ(wire.corners.size(), 2u);
  EXPECT_TRUE(wire.triangles.empty());
  EXPECT_EQ(wire.edges.front().corners[0], -1);
  EXPECT_EQ(wire.edges.back().corners[1], -1);
  for (std::size_t e = 0; e < 3; ++e) {
    EXPECT_TRUE(wire.edges[e].free_cone);
    EXPECT_EQ(wire.edges[e].a, points[e]);
    EXPECT_EQ(wire.edges[e].b, points[e + 1]);
    if (e > 0) {
      EXPECT_EQ(wire.corners[static_cast<std::size_t>(wire.edges[e].corners[0])].position, points[e]);
    }
    if (e < 2) {
      EXPECT_EQ(wire.corners[static_cast<std::size_t>(wire.edges[e].corners[1])].position, points[e + 1]);
    }
  }
  EXPECT_FALSE(signed_distance(wire, {}, {0.5, 0, 0}).has_value());
}

TEST(MakeWire, ClosesALoopWithAJointAtEveryPoint) {
  const ObstacleShape loop = make_wire({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}});
  ASSERT_EQ(loop.edges.size(), 3u);
  ASSERT_EQ(loop.corners.size(), 3u);
  for (const SharpEdge& edge : loop.edges) {
    EXPECT_EQ(loop.corners[static_cast<std::size_t>(edge.corners[0])].position, edge.a);
    EXPECT_EQ(loop.corners[static_cast<std::size_t>(edge.corners[1])].position, edge.b);
  }
}

TEST(MakeWire, RefusesWhatIsNoPolyline) {
  EXPECT_THROW((void)make_wire({{0, 0, 0}}), std::invalid_argument);
  EXPECT_THROW((void)make_wire({{0, 0, 0}, {0, 0, 0}}), std::invalid_argument);
  EXPECT_THROW((void)make_wire({{0, 0, 0}, {1, 0, std::nan("")}}), std::invalid_argument);
}

TEST(MakePoint, KeepsTheDirectionOfTheNormalAtAnyLength) {
  for (const double length : {1e-300, 1.0, 1e300}) {
    const ObstacleShape point = make_point(length * Vec3(0.6, 0, -0.8));
    ASSERT_EQ(point.corners.size(), 1u);
    ASSERT_EQ(point.corners[0].normals.size(), 1u);
    EXPECT_NEAR((point.corners[0].normals[0] - Vec3(0.6, 0, -0.8)).norm(), 0, 1e-15);
  }
  EXPECT_THROW((void)make_point(Vec3::Zero()), std::invalid_argument);
}

// The bisector of the fold is +z by symmetry, whatever the bend: folded round the wire up to back to back, where the
// normals of the two sides cancel, and past it; bent away from it up to a right angle each way.
TEST(WireNormal, IsTheBisectorOfTheFoldOnTheSheetsSide) {
  std::mt19937_64 rng(3);
  SCOPED_TRACE("seed 3");
  for (const double bend : {-40.0, -5.0, 0.0, 1e-6, 30.0, 60.0, 89.0, 90.0, 95.0}) {
    for (const int side : {1, -1}) {
      Cloth cloth = folded_sheet(side * bend * degrees, side);
      const Mat3 turn = Eigen::AngleAxisd(2.0, unit_vector(rng)).toRotationMatrix();
      for (Vec3& x : cloth.mesh.x) x = turn * x + Vec3(1, 2, 3);
      for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
        if (!cloth.is_eol(v)) continue;
        const Vec3 normal = wire_normal(cloth, v, turn.col(1));
        EXPECT_NEAR(normal.dot(turn.col(2)), side, 1e-12) << "bend " << bend << " side " << side;
      }
    }
  }
}

TEST(WireNormal, IsZeroWhereTheSideIsNotKnown) {
  const Cloth cloth = folded_sheet(0.3, 0);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
    if (cloth.is_eol(v)) {
      EXPECT_TRUE(wire_normal(cloth, v, Vec3::UnitY()).isZero(0));
    }
}

TEST(SpreadWireSides, FollowsTheChainElseTheGap) {
  const ObstacleShape shape = make_wire({{0, -1, 0}, {0, 2, 0}});
  const PosedObstacle wire{&shape, {}};
  Cloth cloth = folded_sheet(0.3, 0);
  std::vector<int> chain;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
    if (cloth.is_eol(v)) chain.push_back(v);
  for (const int v : chain)
    for (const int u : chain)
      if (const int h = v == u ? Mesh::none : cloth.mesh.find_edge(v, u); h != Mesh::none)
        cloth.mesh.set_tag(h, edge_tag(0, 0));
  cloth.feature[chain.back()].side = -1;
  Cloth known = cloth;
  spread_wire_sides(known, {&wire, 1});
  for (const int v : chain) EXPECT_EQ(known.feature[v].side, -1);

  for (const double gap : {1e-4, -1e-4}) {
    Cloth alone = folded_sheet(0.3, 0);
    for (Vec3& x : alone.mesh.x) x.z() += gap;
    spread_wire_sides(alone, {&wire, 1});
    for (const int v : chain) EXPECT_EQ(alone.feature[v].side, gap > 0 ? 1 : -1);
  }
}

TEST(FeatureId, NamesAPlaceWhateverTheSide) {
  EXPECT_EQ((FeatureId{0, FeatureKind::Edge, 3, 1}), (FeatureId{0, FeatureKind::Edge, 3, -1}));
  EXPECT_FALSE((FeatureId{0, FeatureKind::Edge, 3}) == (FeatureId{0, FeatureKind::Corner, 3}));
}

}  // namespace
}  // namespace crease
