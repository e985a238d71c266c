// SPDX-License-Identifier: MIT
#include "crease/geometry/obstacle.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

#include "crease/geometry/distance.hpp"

namespace crease {
namespace {

using Rng = std::mt19937_64;

double uniform(Rng& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

Vec3 random_point(Rng& rng, double size = 1) {
  return {uniform(rng, -size, size), uniform(rng, -size, size), uniform(rng, -size, size)};
}

std::array<Vec3, 3> corners_of(const ObstacleShape& shape, const std::array<int, 3>& t) {
  return {shape.vertices[static_cast<std::size_t>(t[0])], shape.vertices[static_cast<std::size_t>(t[1])],
          shape.vertices[static_cast<std::size_t>(t[2])]};
}

TEST(MakeBox, IsAClosedOutwardSurface) {
  const Vec3 size(1.2, 1.5, 0.7);
  const ObstacleShape box = make_box(size);
  ASSERT_EQ(box.vertices.size(), 8u);
  ASSERT_EQ(box.triangles.size(), 12u);
  double volume = 0, area = 0;
  std::set<std::pair<int, int>> directed;
  for (const auto& t : box.triangles) {
    const auto x = corners_of(box, t);
    volume += x[0].dot(x[1].cross(x[2])) / 6;  // positive only if the triangle faces away from the origin
    EXPECT_GT(x[0].dot(x[1].cross(x[2])), 0);
    area += (x[1] - x[0]).cross(x[2] - x[0]).norm() / 2;
    for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(directed.insert({t[k], t[(k + 1) % 3]}).second);
  }
  EXPECT_NEAR(volume, size.prod(), 1e-15);
  EXPECT_NEAR(area, 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x()), 1e-14);
  for (const auto& [a, b] : directed) EXPECT_TRUE(directed.count({b, a})) << "side without neighbour";
}

TEST(MakeBox, HasSharpFeaturesWithOutwardNormals) {
  const ObstacleShape box = make_box({1, 2, 3});
  ASSERT_EQ(box.corners.size(), 8u);
  ASSERT_EQ(box.edges.size(), 12u);
  for (const SharpCorner& corner : box.corners) {
    ASSERT_EQ(corner.normals.size(), 3u);
    for (const Vec3& n : corner.normals) {
      EXPECT_NEAR(n.norm(), 1, 0);
      EXPECT_NEAR(n.dot(corner.position), n.cwiseAbs().dot(box.half_size), 1e-15);
    }
  }
  std::set<std::pair<int, int>> ends;
  for (const SharpEdge& edge : box.edges) {
    EXPECT_TRUE(ends.insert(std::minmax(edge.corners[0], edge.corners[1])).second);
    EXPECT_EQ(edge.a, box.corners[static_cast<std::size_t>(edge.corners[0])].position);
    EXPECT_EQ(edge.b, box.corners[static_cast<std::size_t>(edge.corners[1])].position);
    EXPECT_FALSE(edge.free_cone);
    EXPECT_EQ(edge.normals[0].dot(edge.normals[1]), 0);
    for (const Vec3& n : edge.normals) {
      EXPECT_EQ(n.dot(edge.b - edge.a), 0);
      EXPECT_GT(n.dot(edge.a), 0);
    }
  }
}

TEST(MakeBox, RefusesSizesThatAreNotPositive) {
  EXPECT_THROW(make_box({1, 0, 1}), std::invalid_argument);
  EXPECT_THROW(make_box({1, -1, 1}), std::invalid_argument);
  EXPECT_THROW(make_box({1, std::numeric_limits<double>::quiet_NaN(), 1}), std::invalid_argument);
}

// Oracle: the distance to the nearest of the twelve triangles, with the sign of the box's three slabs.
TEST(SignedDistance, AgreesWithTheNearestTriangleOfATurnedBox) {
  SCOPED_TRACE("seed 11");
  Rng rng(11);
  const ObstacleShape box = make_box({0.4, 1.0, 0.6});
  for (int i = 0; i < 1000; ++i) {
    Pose pose;
    pose.position = random_point(rng);
    pose.rotation = Eigen::AngleAxisd(uniform(rng, 0, M_PI), random_point(rng).normalized()).toRotationMatrix();
    const Vec3 local = random_point(rng), p = pose.to_world(local);
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& t : box.triangles) {
      const auto x = corners_of(box, t);
      const Vec3 w = closest_on_triangle(local, x);
      nearest = std::min(nearest, (w[0] * x[0] + w[1] * x[1] + w[2] * x[2] - local).norm());
    }
    const bool inside = (local.cwiseAbs().array() < box.half_size.array()).all();
    EXPECT_NEAR(signed_distance(box, pose, p).value(), inside ? -nearest : nearest, 1e-14);
  }
}

TEST(SignedDistance, IsAbsentWithoutASurface) {
  ObstacleShape shape;
  shape.kind = ObstacleShape::Kind::Point;
  EXPECT_FALSE(signed_distance(shape, {}, Vec3::Zero()));
  shape.kind = ObstacleShape::Kind::Wire;
  EXPECT_FALSE(signed_distance(shape, {}, Vec3::Zero()));
  shape.kind = ObstacleShape::Kind::Mesh;  // without its surface: not made by make_mesh
  EXPECT_THROW(signed_distance(shape, {}, Vec3::Zero()), std::invalid_argument);
}

Obstacle spinning_obstacle() {
  Obstacle obstacle;
  obstacle.start.position = {1, 2, 3};
  obstacle.start.rotation = Eigen::AngleAxisd(0.3, Vec3::UnitX()).toRotationMatrix();
  obstacle.motion = {{0.1, {1, 0, 0}, {0, 0, 2}}, {0.6, {0, 0, -3}, {1, 1, 0}}, {0.9, {0, 0, 0}, {0, 0, 0}}};
  return obstacle;
}

TEST(PoseAt, RestsBeforeTheFirstKeyAndWithoutMotion) {
  Obstacle obstacle = spinning_obstacle();
  const Pose before = pose_at(obstacle, 0.05);
  EXPECT_EQ(before.position, obstacle.start.position);
  EXPECT_EQ(before.rotation, obstacle.start.rotation);
  EXPECT_EQ(before.velocity, Vec3::Zero());
  obstacle.motion.clear();
  EXPECT_EQ(pose_at(obstacle, 7).position, obstacle.start.position);
}

TEST(PoseAt, IntegratesConstantTwistsInClosedForm) {
  const Obstacle obstacle = spinning_obstacle();
  const Pose pose = pose_at(obstacle, 2);
  EXPECT_LE((pose.position - Vec3(1.5, 2, 3 - 0.9)).norm(), 1e-14);
  const Mat3 first = Eigen::AngleAxisd(1.0, Vec3::UnitZ()).toRotationMatrix();
  const Mat3 second = Eigen::AngleAxisd(0.3 * std::sqrt(2.0), Vec3(1, 1, 0).normalized()).toRotationMatrix();
  EXPECT_LE((pose.rotation - second * first * obstacle.start.rotation).norm(), 1e-14);
  EXPECT_EQ(pose.velocity, Vec3::Zero());
  EXPECT_EQ(pose_at(obstacle, 0.6).velocity, Vec3(0, 0, -3)) << "a key holds from its own time on";
}

// d/dt of the world position of a body point is velocity_at, everywhere between the keys.
TEST(PoseAt, MovesEveryPointWithItsVelocity) {
  SCOPED_TRACE("seed 12");
  Rng rng(12);
  const Obstacle obstacle = spinning_obstacle();
  for (const double time : {0.05, 0.2, 0.59, 0.7, 0.89, 1.5}) {
    const Vec3 body = random_point(rng);
    const double h = 1e-5;
    const Vec3 rate =
        (pose_at(obstacle, time + h).to_world(body) - pose_at(obstacle, time - h).to_world(body)) / (2 * h);
    const Pose pose = pose_at(obstacle, time);
    // Central differences: truncation h^2 |omega|^3 / 6 ~ 1e-9, round-off 1e-16 / h ~ 1e-10.
    EXPECT_LE((rate - pose.velocity_at(pose.to_world(body))).norm(), 1e-8) << time;
    EXPECT_LE((pose.to_local(pose.to_world(body)) - body).norm(), 1e-14);
  }
}

TEST(PoseAt, RefusesTimesThatMakeNoSense) {
  Obstacle obstacle = spinning_obstacle();
  EXPECT_THROW(pose_at(obstacle, -1), std::invalid_argument);
  EXPECT_THROW(pose_at(obstacle, std::numeric_limits<double>::infinity()), std::invalid_argument);
  std::swap(obstacle.motion[0], obstacle.motion[1]);
  EXPECT_THROW(pose_at(obstacle, 1), std::invalid_argument);
}

}  // namespace
}  // namespace crease
