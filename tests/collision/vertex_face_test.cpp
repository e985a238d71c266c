// SPDX-License-Identifier: MIT
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/collision/detect.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

using support::Rng;
using support::uniform;

// One triangle whose vertex 0 is at p; the two others are far out of reach of a box about the origin.
Cloth cloth_with_vertex_at(const Vec3& p) {
  return make_cloth(Mesh({{0, 0}, {1, 0}, {0, 1}}, {p, {9, 0, 0}, {0, 9, 0}}, {{0, 1, 2}}));
}

std::vector<Contact> vertex_contacts(const Cloth& cloth, const PosedObstacle& obstacle, const DetectOptions& options) {
  std::vector<Contact> found;
  for (const Contact& c : Detector().detect(cloth, {&obstacle, 1}, options)) {
    if (c.type == ContactType::VertexFace) found.push_back(c);
  }
  return found;
}

// A vertex beyond the box by `step` along each axis with its sign in `region`: all 26 regions around the box.
TEST(VertexFace, PointsFromTheNearestPointInEveryRegionOutside) {
  const Vec3 half(0.5, 0.4, 0.3);
  const ObstacleShape shape = make_box(2 * half);
  PosedObstacle box{&shape, {}};
  box.pose.rotation = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  box.pose.position = {0.1, -0.2, 0.05};
  for (int i = 0; i < 27; ++i) {
    const Vec3 region(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (region.isZero()) continue;
    const Vec3 step(0.003, 0.004, 0.005), inner(0.11, -0.07, 0.13);
    Vec3 nearest, offset;
    for (int k = 0; k < 3; ++k) {
      nearest[k] = region[k] == 0 ? inner[k] : region[k] * half[k];
      offset[k] = region[k] * step[k];
    }
    const auto contacts = vertex_contacts(cloth_with_vertex_at(box.pose.to_world(nearest + offset)), box, {0.01, 0});
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_LE((contacts[0].point - box.pose.to_world(nearest)).norm(), 1e-12);
    EXPECT_LE((contacts[0].normal - box.pose.rotation * offset.normalized()).norm(), 1e-12);
    EXPECT_NEAR(contacts[0].distance, offset.norm(), 1e-12);
    EXPECT_EQ(contacts[0].feature, FeatureId{});
    EXPECT_TRUE(vertex_contacts(cloth_with_vertex_at(box.pose.to_world(nearest + 4 * offset)), box, {0.01, 0}).empty());
  }
}

TEST(VertexFace, LeavesTheInsideThroughTheFaceOfLeastDepth) {
  SCOPED_TRACE("seed 1");
  Rng rng(1);
  const Vec3 half(0.5, 0.4, 0.3);
  const ObstacleShape shape = make_box(2 * half);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p(uniform(rng, -0.5, 0.5), uniform(rng, -0.4, 0.4), uniform(rng, -0.3, 0.3));
    const auto contacts = vertex_contacts(cloth_with_vertex_at(p), {&shape, {}}, {});
    ASSERT_EQ(contacts.size(), 1u);
    int axis = 0;
    const double depth = (half - p.cwiseAbs()).minCoeff(&axis);
    EXPECT_NEAR(contacts[0].distance, -depth, 1e-14);
    EXPECT_EQ(contacts[0].normal, Vec3(std::copysign(1.0, p[axis]) * Vec3::Unit(axis)));
  }
}

// The direction from the rim is the gradient of the distance: differentiated numerically, it must be the normal.
TEST(VertexFace, NormalIsTheGradientOfTheSignedDistance) {
  SCOPED_TRACE("seed 2");
  Rng rng(2);
  const ObstacleShape shape = make_box({0.6, 0.5, 0.4});
  for (int i = 0; i < 200; ++i) {
    PosedObstacle box{&shape, {}};
    box.pose.rotation =
        Eigen::AngleAxisd(uniform(rng, 0, 3), Vec3(uniform(rng, -1, 1), 1, uniform(rng, -1, 1)).normalized());
    const Vec3 p(uniform(rng, -0.5, 0.5), uniform(rng, -0.5, 0.5), uniform(rng, -0.5, 0.5));
    const auto contacts = vertex_contacts(cloth_with_vertex_at(p), box, {1, 0});
    ASSERT_FALSE(contacts.empty());
    Vec3 gradient;
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Vec3 step = h * Vec3::Unit(k);
      gradient[k] =
          (*signed_distance(shape, box.pose, p + step) - *signed_distance(shape, box.pose, p - step)) / (2 * h);
    }
    if (std::abs(gradient.norm() - 1) > 1e-4) continue;  // the difference straddles a kink inside
    // Truncation h^2 / distance^2 near a rim, round-off 1e-16 / h.
    EXPECT_LE((gradient - contacts[0].normal).norm(), 1e-4);
  }
}

// A sheet lies flat on the top and one of its mesh lines lies exactly on the rim. All normals point up: the vertices on
// the rim are not pushed outwards. (A mean normal there makes the sheet creep off the box.)
TEST(VertexFace, FlatClothIsPushedStraightUpAtTheRim) {
  GridOptions grid;
  grid.cells = {8, 8};
  const Cloth cloth = make_cloth(make_grid(grid));
  const ObstacleShape shape = make_box({1, 3, 1});
  PosedObstacle box{&shape, {}};
  box.pose.position = {1, 0.5, -0.5};  // the rim at x = 1/2 is a mesh line
  const auto contacts = vertex_contacts(cloth, box, {1e-3, 0});
  int on_rim = 0;
  for (const Contact& c : contacts) {
    if (cloth.mesh.x[c.vertices[0]].x() < 0.5) continue;
    on_rim += cloth.mesh.x[c.vertices[0]].x() == 0.5;
    EXPECT_LE((c.normal - Vec3::UnitZ()).norm(), 1e-12);
    EXPECT_NEAR(c.distance, 0, 1e-15);
  }
  EXPECT_EQ(on_rim, 9);
}

// Folded down by 90 degrees over the rim: the normal of the vertices on the rim lies between those of the two faces,
// and any motion into both half spaces is against it.
TEST(VertexFace, FoldedClothIsPushedWithinTheConeAtTheRim) {
  GridOptions grid;
  grid.cells = {8, 8};
  Cloth cloth = make_cloth(make_grid(grid));
  for (Vec3& x : cloth.mesh.x) {
    if (x.x() < 0.5) x = {0.5, x.y(), x.x() - 0.5};
  }
  const ObstacleShape shape = make_box({1, 3, 2});
  PosedObstacle box{&shape, {}};
  box.pose.position = {1, 0.5, -1};
  int on_rim = 0;
  for (const Contact& c : vertex_contacts(cloth, box, {1e-3, 0})) {
    const Vec3& x = cloth.mesh.x[c.vertices[0]];
    if (x.x() > 0.5 || x.z() < 0) continue;
    ++on_rim;
    EXPECT_GT(c.normal.z(), 0.3);
    EXPECT_LT(c.normal.x(), -0.3);
    EXPECT_NEAR(c.normal.y(), 0, 1e-12);
  }
  EXPECT_EQ(on_rim, 9);
}

TEST(VertexFace, VertexOnACornerIsPushedWithinTheCone) {
  const ObstacleShape shape = make_box({1, 1, 1});
  const Vec3 corner(0.5, 0.5, 0.5);
  const auto contacts = vertex_contacts(cloth_with_vertex_at(corner), {&shape, {}}, {});
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_GE(contacts[0].normal.minCoeff(), -1e-12);
  EXPECT_NEAR(contacts[0].distance, 0, 1e-15);
}

TEST(VertexFace, LeavesOutVerticesThatRideOnTheSameObstacleOnly) {
  const ObstacleShape shape = make_box({1, 1, 1});
  std::vector<PosedObstacle> boxes{{&shape, {}}, {&shape, {}}};
  boxes[1].pose.position.z() = 1;  // stands on the first
  Cloth cloth = cloth_with_vertex_at({0.5, 0.1, 0.5});
  cloth.feature[0] = {0, FeatureKind::Edge, 7};
  std::vector<int> obstacles;
  for (const Contact& c : Detector().detect(cloth, boxes, {})) {
    if (c.type == ContactType::VertexFace) obstacles.push_back(c.obstacle);
  }
  EXPECT_EQ(obstacles, std::vector<int>{1});
}

TEST(VertexFace, FindsAFoldThatHasLiftedOffLikeAnyVertex) {
  const ObstacleShape shape = make_box({1, 1, 1});
  const PosedObstacle box{&shape, {}};
  Cloth cloth = cloth_with_vertex_at({0.5004, 0.1, 0.5});
  cloth.feature[0] = {0, FeatureKind::Edge, 7};
  EXPECT_TRUE(vertex_contacts(cloth, box, {}).empty());
  cloth.feature[0].lifted = true;
  const std::vector<Contact> contacts = vertex_contacts(cloth, box, {});
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].distance, 4e-4, 1e-15);
}

}  // namespace
}  // namespace crease
