// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/collision/detect.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

constexpr double degrees = M_PI / 180;

std::vector<Contact> edge_contacts(const Cloth& cloth, const PosedObstacle& obstacle, const DetectOptions& options) {
  std::vector<Contact> found;
  for (const Contact& c : Detector().detect(cloth, {&obstacle, 1}, options)) {
    if (c.type == ContactType::EdgeEdge) found.push_back(c);
  }
  return found;
}

// Top at z = 0, a vertical side at x = rim facing -x, all other sides out of reach of the unit square.
PosedObstacle table(const ObstacleShape& shape, double rim) {
  PosedObstacle box{&shape, {}};
  box.pose.position = {rim + shape.half_size.x(), 0.5, -shape.half_size.z()};
  return box;
}

// The edge of a table that the sheets below cross.
int rim_edge(const ObstacleShape& shape) {
  for (std::size_t e = 0; e < shape.edges.size(); ++e) {
    const SharpEdge& edge = shape.edges[e];
    if (edge.a.z() > 0 && edge.b.z() > 0 && edge.a.x() < 0 && edge.b.x() < 0) return static_cast<int>(e);
  }
  return -1;
}

Cloth sheet(GridPattern pattern, double height = 0, int n = 7) {
  GridOptions options;
  options.cells = {n, n};
  options.pattern = pattern;
  options.origin = {0, 0, height};
  return make_cloth(make_grid(options));
}

// One triangle with the cloth edge p-q, its third vertex out of reach.
Cloth cloth_with_edge(const Vec3& p, const Vec3& q, const Vec3& far = {-9, 0, 9}) {
  return make_cloth(Mesh({{0, 0}, {1, 0}, {0, 1}}, {p, q, far}, {{0, 1, 2}}));
}

// A flat sheet across the rim, on it, above it and sunk into it: every mesh edge that crosses x = rim is reported, with
// the top's normal (the rim of the cone), and no other feature is.
TEST(EdgeEdge, ReportsEveryEdgeOfAFlatSheetAcrossTheRim) {
  const ObstacleShape shape = make_box({2, 5, 1});
  const double rim = 0.4321;
  for (const GridPattern pattern :
       {GridPattern::Cross, GridPattern::Alternating, GridPattern::Right, GridPattern::Irregular}) {
    for (const double height : {0.0, 5e-4, -5e-4, 1e-13, -1e-13}) {
      const Cloth cloth = sheet(pattern, height);
      std::set<int> expected;
      for (const int h : cloth.mesh.edges()) {
        const double a = cloth.mesh.x[cloth.mesh.from(h)].x() - rim, b = cloth.mesh.x[cloth.mesh.to(h)].x() - rim;
        if (a * b < 0) expected.insert(h);
      }
      std::set<int> found;
      for (const Contact& c : edge_contacts(cloth, table(shape, rim), {1e-3, 0})) {
        EXPECT_EQ(c.feature.index, rim_edge(shape));
        EXPECT_LE((c.normal - Vec3::UnitZ()).norm(), 1e-9);
        EXPECT_NEAR(c.distance, height, 1e-12);
        EXPECT_NEAR(c.point.x(), rim, 1e-12);
        EXPECT_NEAR(c.point.z(), 0, 1e-12);
        found.insert(c.halfedge);
      }
      EXPECT_EQ(found, expected);
    }
  }
}

// A sheet that covers the whole top of a box crosses its four upper edges. The upright edges end in the top's corners
// and would push the sheet sideways; the lower ones of a thin plate would pull it down.
TEST(EdgeEdge, TouchesOnlyTheUpperEdgesUnderAFlatSheet) {
  for (const double thickness : {1.0, 1e-2, 2e-3, 5e-4}) {
    const ObstacleShape shape = make_box({0.52, 0.61, thickness});
    PosedObstacle box{&shape, {}};
    box.pose.rotation = Eigen::AngleAxisd(0.4, Vec3::UnitZ()).toRotationMatrix();
    for (const double height : {0.0, 1e-12, -1e-12, 1e-4, -1e-4}) {
      box.pose.position = {0.5, 0.5, -thickness / 2 - height};
      const auto contacts = edge_contacts(sheet(GridPattern::Irregular, 0, 12), box, {1e-3, 0});
      std::set<int> features;
      for (const Contact& c : contacts) {
        EXPECT_LE((c.normal - Vec3::UnitZ()).norm(), 1e-9);
        EXPECT_NEAR(c.distance, height, 1e-12);
        features.insert(c.feature.index);
        EXPECT_GT(shape.edges[c.feature.index].a.z() + shape.edges[c.feature.index].b.z(), 0);
      }
      EXPECT_EQ(features.size(), 4u);
    }
  }
}

// Vertices on the top and on the side, folded by 90 degrees: an edge from (a, 0) to (0, -b) cuts the rim at the depth
// of the altitude of that right triangle, whatever the tilt along the rim.
TEST(EdgeEdge, MeasuresHowDeepAFoldCutsTheRim) {
  const ObstacleShape shape = make_box({2, 5, 2});
  for (const double a : {0.002, 0.02, 0.2}) {
    for (const double b : {0.003, 0.03, 0.3}) {
      for (const double tilt : {0.0, 0.05}) {
        const Cloth cloth = cloth_with_edge({0.4 + a, 0.5, 0}, {0.4, 0.5 + tilt, -b});
        const auto contacts = edge_contacts(cloth, table(shape, 0.4), {1e-3, 0});
        ASSERT_EQ(contacts.size(), 1u) << a << " " << b;
        EXPECT_NEAR(contacts[0].distance, -a * b / std::hypot(a, b), 1e-12);
        EXPECT_LE((contacts[0].normal - Vec3(-b, 0, a).normalized()).norm(), 1e-12);
        EXPECT_EQ(contacts[0].feature.index, rim_edge(shape));
      }
    }
  }
}

// Mesh lines exactly on the rim: the edges there are parallel to it and say nothing, but every vertex on it is the end
// of one that reaches across.
TEST(EdgeEdge, ReportsARimThroughClothVertices) {
  const ObstacleShape shape = make_box({2, 5, 1});
  for (const GridPattern pattern : {GridPattern::Cross, GridPattern::Alternating, GridPattern::Right}) {
    for (const double offset : {0.0, 1e-16, -1e-16, 1e-12, -1e-12}) {
      for (const double fold : {0.0, 0.5, 1.0}) {  // quarter turns
        Cloth cloth = sheet(pattern, 0, 8);
        for (Vec3& x : cloth.mesh.x) {
          const double s = 0.5 - x.x();
          if (s > 0) x = {0.5 - s * std::cos(fold * M_PI / 2), x.y(), -s * std::sin(fold * M_PI / 2)};
        }
        const PosedObstacle box = table(shape, 0.5 + offset);
        std::set<int> at;
        for (const Contact& c : edge_contacts(cloth, box, {1e-3, 0})) {
          for (int k = 0; k < 2; ++k) {
            if (c.weights[k] > 1 - 1e-9) at.insert(c.vertices[k]);
          }
        }
        for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
          const bool on_rim = std::abs(cloth.mesh.X[i].x() - 0.5) < 1e-12;
          EXPECT_TRUE(!on_rim || at.count(i)) << "offset " << offset << " fold " << fold;
        }
      }
    }
  }
}

TEST(EdgeEdge, LeavesOutEdgesWithinTwoDegreesOfTheRim) {
  const ObstacleShape shape = make_box({2, 5, 1});
  for (const double angle : {0.5, 1.5, 2.5, 30.0}) {
    const Vec3 half(0.1 * std::sin(angle * degrees), 0.1 * std::cos(angle * degrees), 0), middle(0.4, 0.5, 0);
    const auto contacts = edge_contacts(cloth_with_edge(middle - half, middle + half), table(shape, 0.4), {1e-3, 0});
    EXPECT_EQ(contacts.size(), angle > 2 ? 1u : 0u) << angle;
  }
}

// Rising outwards, a sheet touches the rim only if it cuts the top: not a contact of the rim, up to 2 degrees.
TEST(EdgeEdge, KeepsTheNormalInTheConeOfTheFaces) {
  const ObstacleShape shape = make_box({2, 5, 1});
  for (const double rise : {-100.0, -91.0, -89.0, -45.0, -1.0, 0.0, 1.0, 3.0, 45.0}) {
    const Vec3 outward(-0.1 * std::cos(rise * degrees), 0, 0.1 * std::sin(rise * degrees)), middle(0.4, 0.5, 0);
    const auto contacts =
        edge_contacts(cloth_with_edge(middle - outward, middle + outward), table(shape, 0.4), {1e-3, 0});
    EXPECT_EQ(contacts.size(), rise < 2 && rise > -92 ? 1u : 0u) << rise;
  }
}

// A sheet that stabs through the middle of the top, or stands on it just inside the rim, is not in contact with the
// rim.
TEST(EdgeEdge, LeavesAStabThroughAFaceToThatFace) {
  const ObstacleShape shape = make_box({2, 5, 1});
  for (const double inside : {5e-4, 5e-3, 0.05}) {
    for (const double depth : {0.0, 1e-4, 1e-12}) {
      const Cloth cloth = cloth_with_edge({0.4 + inside, 0.5, -depth}, {0.4 + inside, 0.5, 0.2});
      EXPECT_TRUE(edge_contacts(cloth, table(shape, 0.4), {1e-3, 0}).empty()) << inside << " " << depth;
    }
  }
}

// Vertices outside on both sides of a narrow bar, the sheet sunk by 2 mm: no vertex says so, only the edges.
TEST(EdgeEdge, SeesABarThatNoVertexTouches) {
  const ObstacleShape shape = make_box({0.01, 5, 0.05});
  PosedObstacle bar{&shape, {}};
  bar.pose.position = {0.5, 0.5, -0.025 + 0.002};
  const auto contacts = edge_contacts(cloth_with_edge({0.4, 0.5, 0}, {0.6, 0.55, 0}), bar, {1e-3, 0});
  ASSERT_EQ(contacts.size(), 2u);
  for (const Contact& c : contacts) {
    EXPECT_NEAR(c.distance, -0.002, 1e-12);
    EXPECT_LE((c.normal - Vec3::UnitZ()).norm(), 1e-9);
  }
}

TEST(EdgeEdge, LeavesOutEdgesThatEndOnTheSameFeatureOrItsCorners) {
  const ObstacleShape shape = make_box({2, 5, 1});
  Cloth cloth = cloth_with_edge({0.4, 0.5, 0}, {0.5, 0.6, 0});
  const PosedObstacle box = table(shape, 0.4);
  const int rim = rim_edge(shape);
  EXPECT_EQ(edge_contacts(cloth, box, {}).size(), 1u);
  cloth.feature[0] = {0, FeatureKind::Edge, rim};
  EXPECT_TRUE(edge_contacts(cloth, box, {}).empty());
  cloth.feature[0] = {0, FeatureKind::Corner, shape.edges[rim].corners[1]};
  EXPECT_TRUE(edge_contacts(cloth, box, {}).empty());
  cloth.feature[0] = {0, FeatureKind::Edge, rim == 0 ? 1 : 0};
  EXPECT_EQ(edge_contacts(cloth, box, {}).size(), 1u);
  cloth.feature[0] = {1, FeatureKind::Edge, rim};  // the same number on another obstacle
  EXPECT_EQ(edge_contacts(cloth, box, {}).size(), 1u);
}

// What every step of a sliding sheet looks like: the chain is on the rim, both sides lie flush on their faces.
TEST(EdgeEdge, FindsNothingAroundAChainThatIsInPlace) {
  const ObstacleShape shape = make_box({2, 5, 2});
  const PosedObstacle box = table(shape, 0.5);
  for (const double fold : {0.0, 0.1, 0.5, 1.0}) {  // quarter turns
    Cloth cloth = sheet(GridPattern::Cross, 0, 8);
    for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
      Vec3& x = cloth.mesh.x[i];
      const double s = 0.5 - x.x();
      if (s > 0) x = {0.5 - s * std::cos(fold * M_PI / 2), x.y(), -s * std::sin(fold * M_PI / 2)};
      if (s == 0) cloth.feature[i] = {0, FeatureKind::Edge, rim_edge(shape)};
    }
    EXPECT_TRUE(edge_contacts(cloth, box, {1e-3, 0.005}).empty());
    for (const Contact& c : Detector().detect(cloth, {&box, 1}, {1e-3, 0})) {
      EXPECT_FALSE(cloth.is_eol(c.vertices[0]));
      EXPECT_NEAR(std::max(c.normal.z(), -c.normal.x()), 1, 1e-12);
    }
  }
}

TEST(EdgeEdge, TouchesAWireFromTheSideTheClothIsOn) {
  ObstacleShape shape;
  shape.kind = ObstacleShape::Kind::Wire;
  SharpEdge segment;
  segment.a = {-1, 0, 0};
  segment.b = {1, 0, 0};
  segment.normals = {Vec3::Zero(), Vec3::Zero()};
  segment.free_cone = true;
  shape.edges = {segment};
  const PosedObstacle wire{&shape, {}};
  const Vec3 beyond(9, 0, 0);
  for (int i = 0; i < 8; ++i) {
    const Vec3 off(0, std::cos(i * 45 * degrees), std::sin(i * 45 * degrees)), along = Vec3::UnitX().cross(off);
    const Vec3 middle = 5e-4 * off;
    const Cloth cloth = cloth_with_edge(middle - 0.1 * along, middle + 0.1 * along, beyond);
    const auto contacts = edge_contacts(cloth, wire, {1e-3, 0});
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_LE((contacts[0].normal - off).norm(), 1e-12);
    EXPECT_NEAR(contacts[0].distance, 5e-4, 1e-15);
  }
  // Exactly on the wire: from where it comes.
  Cloth cloth = cloth_with_edge({0, -0.1, 0}, {0, 0.1, 0}, beyond);
  for (const double speed : {-1.0, 1.0}) {
    for (Vec3& v : cloth.v) v = {0, 0, speed};
    const auto contacts = edge_contacts(cloth, wire, {1e-3, 0});
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_LE((contacts[0].normal - Vec3(0, 0, -speed)).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace crease
