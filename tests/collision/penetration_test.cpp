// SPDX-License-Identifier: MIT
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/collision/detect.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

using support::Rng;
using support::uniform;

TEST(MaxPenetration, IsTheDepthOfASunkenSheet) {
  SCOPED_TRACE("seed 1");
  Rng rng(1);
  const ObstacleShape shape = make_box({3, 3, 1});
  for (const double depth : {-0.1, 0.0, 1e-6, 0.01, 0.3}) {
    Cloth cloth = make_cloth(support::grid(GridPattern::Irregular));
    PosedObstacle box{&shape, {}};
    box.pose.position = {0.5, 0.5, depth - 0.5};
    EXPECT_NEAR(max_penetration(cloth, {&box, 1}), std::max(depth, 0.0), 1e-12);
    // The same in a turned scene.
    const Mat3 R = Eigen::AngleAxisd(uniform(rng, 0, 3), Vec3(1, -2, 1).normalized()).toRotationMatrix();
    for (Vec3& x : cloth.mesh.x) x = R * x;
    box.pose.position = R * box.pose.position;
    box.pose.rotation = R;
    EXPECT_NEAR(max_penetration(cloth, {&box, 1}), std::max(depth, 0.0), 1e-12);
  }
}

// All vertices outside: from a on the top to a below the rim on the side, the middle of the fold is a / 2 deep.
TEST(MaxPenetration, SeesAFoldThatCutsTheRimBetweenVertices) {
  const ObstacleShape shape = make_box({2, 2, 2});
  const double a = 0.1;
  const Cloth cloth =
      make_cloth(Mesh({{0, 0}, {1, 0}, {0, 1}}, {{-1 + a, 0, 1}, {-1, 0, 1 - a}, {-1 + a, 0.1, 1}}, {{0, 1, 2}}));
  const PosedObstacle box{&shape, {}};
  EXPECT_NEAR(max_penetration(cloth, {&box, 1}, 1), 0, 1e-15) << "vertices only";
  EXPECT_NEAR(max_penetration(cloth, {&box, 1}, 4), a / 2, 1e-15);
}

TEST(MaxPenetration, IsTheDeepestOfSeveralObstaclesAndNothingForTips) {
  const ObstacleShape shape = make_box({3, 3, 1});
  ObstacleShape nail;
  nail.kind = ObstacleShape::Kind::Point;
  nail.corners = {{Vec3::Zero(), {Vec3::UnitZ()}}};
  std::vector<PosedObstacle> obstacles{{&shape, {}}, {&nail, {}}, {&shape, {}}};
  obstacles[0].pose.position.z() = -0.49;
  obstacles[2].pose.position.z() = -0.48;
  const Cloth cloth = make_cloth(support::grid(GridPattern::Right));
  EXPECT_NEAR(max_penetration(cloth, obstacles), 0.02, 1e-12);
  EXPECT_EQ(max_penetration(cloth, {}), 0);
  EXPECT_THROW(max_penetration(cloth, obstacles, 0), std::invalid_argument);
}

}  // namespace
}  // namespace crease
