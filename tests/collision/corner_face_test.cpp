// SPDX-License-Identifier: MIT
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/collision/detect.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

std::vector<Contact> corner_contacts(const Cloth& cloth, const PosedObstacle& obstacle, const DetectOptions& options) {
  std::vector<Contact> found;
  for (const Contact& c : Detector().detect(cloth, {&obstacle, 1}, options)) {
    if (c.type == ContactType::CornerFace) found.push_back(c);
  }
  return found;
}

Cloth sheet(double height = 0) {
  GridOptions options;
  options.cells = {9, 9};
  options.pattern = GridPattern::Irregular;
  options.origin = {0, 0, height};
  return make_cloth(make_grid(options));
}

ObstacleShape nail() {
  ObstacleShape shape;
  shape.kind = ObstacleShape::Kind::Point;
  shape.corners = {{Vec3::Zero(), {Vec3::UnitZ()}}};
  return shape;
}

TEST(CornerFace, ReportsTheFourUpperCornersUnderAFlatSheet) {
  for (const double thickness : {1.0, 5e-4}) {
    const ObstacleShape shape = make_box({0.52, 0.61, thickness});
    PosedObstacle box{&shape, {}};
    box.pose.rotation = Eigen::AngleAxisd(0.4, Vec3::UnitZ()).toRotationMatrix();
    for (const double height : {0.0, 5e-4, -1e-4}) {
      box.pose.position = {0.5, 0.5, -thickness / 2 - height};
      std::set<int> corners;
      for (const Contact& c : corner_contacts(sheet(), box, {1e-3, 0})) {
        corners.insert(c.feature.index);
        EXPECT_GT(shape.corners[c.feature.index].position.z(), 0);
        EXPECT_LE((c.normal - Vec3::UnitZ()).norm(), 1e-12);
        EXPECT_NEAR(c.distance, height, 1e-12);
      }
      EXPECT_EQ(corners.size(), 4u);
    }
  }
}

// A box standing on its corner pierces the sheet: as deep as the tip stands out, from the side of the box's outside.
TEST(CornerFace, MeasuresHowFarACornerStandsOut) {
  const ObstacleShape shape = make_box({0.3, 0.3, 0.3});
  PosedObstacle box{&shape, {}};
  box.pose.rotation = Eigen::Quaterniond::FromTwoVectors(Vec3(1, 1, 1), Vec3::UnitZ()).toRotationMatrix();
  const double diagonal = 0.15 * std::sqrt(3.0);
  for (const double out : {-5e-4, 1e-4, 1e-3, 0.01}) {
    box.pose.position = {0.512, 0.533, out - diagonal};
    const auto contacts = corner_contacts(sheet(), box, {1e-3, 0});
    ASSERT_EQ(contacts.size(), 1u) << out;
    EXPECT_NEAR(contacts[0].distance, -out, 1e-12);
    EXPECT_LE((contacts[0].normal - Vec3::UnitZ()).norm(), 1e-12);
    EXPECT_EQ(contacts[0].feature.index, 7);
  }
}

TEST(CornerFace, LeavesOutFacesWithAVertexOnTheCorner) {
  const ObstacleShape shape = nail();
  PosedObstacle tip{&shape, {}};
  tip.pose.position = {0.512, 0.533, 0};
  Cloth cloth = sheet();
  const auto contacts = corner_contacts(cloth, tip, {});
  ASSERT_EQ(contacts.size(), 1u);
  cloth.feature[contacts[0].vertices[1]] = {0, FeatureKind::Corner, 0};
  EXPECT_TRUE(corner_contacts(cloth, tip, {}).empty());
}

TEST(CornerFace, ReportsATipUnderAClothVertex) {
  const ObstacleShape shape = nail();
  const Cloth cloth = sheet();
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
    PosedObstacle tip{&shape, {}};
    tip.pose.position = cloth.mesh.x[i];
    const auto contacts = corner_contacts(cloth, tip, {});
    ASSERT_FALSE(contacts.empty());
    for (const Contact& c : contacts) {
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(c.weights[k], c.vertices[k] == i ? 1 : 0, 1e-9);
    }
  }
}

// A tip has no inside: what is behind it by more than the threshold is not pierced, only far. Its axis says which side.
TEST(CornerFace, SeesATipFromBothSidesWithinReachOnly) {
  const ObstacleShape shape = nail();
  for (const bool upwards : {true, false}) {
    PosedObstacle tip{&shape, {}};
    tip.pose.position = {0.512, 0.533, 0};
    if (!upwards) tip.pose.rotation = Eigen::AngleAxisd(M_PI, Vec3::UnitX()).toRotationMatrix();
    for (const double height : {-0.1, -0.0015, -0.0005, 0.0005, 0.0015, 0.1}) {
      const auto contacts = corner_contacts(sheet(height), tip, {1e-3, 0});
      ASSERT_EQ(contacts.size(), std::abs(height) < 1e-3 ? 1u : 0u);
      if (contacts.empty()) continue;
      EXPECT_NEAR(contacts[0].distance, upwards ? height : -height, 1e-15);
      EXPECT_NEAR(contacts[0].normal.z(), upwards ? 1 : -1, 1e-12);
    }
  }
}

TEST(CornerFace, IgnoresFacesDegenerateInTheWorld) {
  const ObstacleShape shape = nail();
  const PosedObstacle tip{&shape, {}};
  const Cloth cloth = make_cloth(Mesh({{0, 0}, {1, 0}, {0, 1}}, {{-1, 0, 0}, {1, 0, 0}, {0.3, 0, 0}}, {{0, 1, 2}}));
  EXPECT_TRUE(corner_contacts(cloth, tip, {}).empty());
}

}  // namespace
}  // namespace crease
