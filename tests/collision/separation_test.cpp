// SPDX-License-Identifier: MIT
#include "crease/collision/separation.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/collision/detect.hpp"
#include "crease/geometry/distance.hpp"
#include "support/meshes.hpp"

// FCL's GJK knows the distance of a triangle and a box, but no features; the detector knows features. Here the two are
// held against each other.
namespace crease {
namespace {

using support::Rng;
using support::uniform;

Vec3 random_point(Rng& rng, double size) {
  return {uniform(rng, -size, size), uniform(rng, -size, size), uniform(rng, -size, size)};
}

struct Pair {
  std::array<Vec3, 3> triangle;
  PosedObstacle box;
};

Pair random_pair(Rng& rng, const ObstacleShape& shape) {
  const Vec3 centre = random_point(rng, 0.6);
  Pair pair{{centre, centre, centre}, {&shape, {}}};
  for (Vec3& p : pair.triangle) p += random_point(rng, 0.3);
  pair.box.pose.rotation = Eigen::AngleAxisd(uniform(rng, 0, M_PI), random_point(rng, 1).normalized());
  return pair;
}

std::vector<double> distances(const Pair& pair, double threshold) {
  const Cloth cloth =
      make_cloth(Mesh({{0, 0}, {1, 0}, {0, 1}}, {pair.triangle[0], pair.triangle[1], pair.triangle[2]}, {{0, 1, 2}}));
  std::vector<double> found;
  for (const Contact& c : Detector().detect(cloth, {&pair.box, 1}, {threshold, 0})) found.push_back(c.distance);
  std::sort(found.begin(), found.end());
  return found;
}

// The one pair of features without a contact type: a corner of the box nearest to the rim of the triangle. In a whole
// cloth that rim is the border, or a ridge.
bool is_corner_to_rim(const Pair& pair, double distance) {
  for (const SharpCorner& corner : pair.box.shape->corners) {
    const Vec3 p = pair.box.pose.to_world(corner.position);
    const Vec3 w = closest_on_triangle(p, pair.triangle);
    const Vec3 q = w[0] * pair.triangle[0] + w[1] * pair.triangle[1] + w[2] * pair.triangle[2];
    if (w.minCoeff() < 1e-12 && std::abs((p - q).norm() - distance) < 1e-9) return true;
  }
  return false;
}

TEST(TriangleDistance, IsTheSmallestGapOfAllContacts) {
  SCOPED_TRACE("seed 1");
  Rng rng(1);
  const ObstacleShape shape = make_box({0.4, 0.6, 0.5});
  int apart = 0, without_type = 0;
  for (int i = 0; i < 3000; ++i) {
    const Pair pair = random_pair(rng, shape);
    const auto distance = triangle_distance(pair.triangle, pair.box);
    ASSERT_TRUE(distance);
    if (*distance == 0) continue;
    ++apart;
    const double smallest = distances(pair, 5).at(0);
    if (is_corner_to_rim(pair, *distance)) {
      ++without_type;
      EXPECT_GE(smallest, *distance - 1e-9);
    } else {
      EXPECT_NEAR(smallest, *distance, 1e-9);
    }
  }
  EXPECT_GT(apart, 2000);
  EXPECT_LT(without_type, apart / 5);
}

TEST(TriangleDistance, IsZeroWhereverAContactPenetrates) {
  SCOPED_TRACE("seed 2");
  Rng rng(2);
  const ObstacleShape shape = make_box({0.4, 0.6, 0.5});
  int penetrating = 0;
  for (int i = 0; i < 3000; ++i) {
    const Pair pair = random_pair(rng, shape);
    const auto found = distances(pair, 1e-3);
    if (found.empty() || found[0] > -1e-9) continue;
    ++penetrating;
    EXPECT_EQ(triangle_distance(pair.triangle, pair.box).value(), 0);
  }
  EXPECT_GT(penetrating, 500);
}

// The other way round: a triangle pushed straight into the box by a little penetrates for both, no deeper than pushed.
TEST(TriangleDistance, ReachesZeroTogetherWithAContact) {
  SCOPED_TRACE("seed 3");
  Rng rng(3);
  const ObstacleShape shape = make_box({0.4, 0.6, 0.5});
  int pushed = 0;
  for (int i = 0; i < 2000; ++i) {
    Pair pair = random_pair(rng, shape);
    const double distance = triangle_distance(pair.triangle, pair.box).value();
    if (distance == 0 || is_corner_to_rim(pair, distance)) continue;
    // The direction of the gap, by differences of GJK's distance.
    Vec3 gradient;
    for (int k = 0; k < 3; ++k) {
      const auto moved = [&](double h) {
        auto triangle = pair.triangle;
        for (Vec3& p : triangle) p[k] += h;
        return triangle_distance(triangle, pair.box).value();
      };
      gradient[k] = (moved(1e-6) - moved(-1e-6)) / 2e-6;
    }
    const double depth = 1e-4;
    for (Vec3& p : pair.triangle) p -= (distance + depth) * gradient.normalized();
    EXPECT_EQ(triangle_distance(pair.triangle, pair.box).value(), 0);
    // Just inside a rim the least depth of a vertex is that of a face, less than the way it was pushed along the
    // diagonal; and where edges meet in a corner a triangle may cut a second one deeper than the one it was pushed
    // into.
    const auto found = distances(pair, 1e-3);
    EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](double d) { return d < 0 && d > -1.001 * depth; }));
    ++pushed;
  }
  EXPECT_GT(pushed, 1000);
}

TEST(TriangleDistance, IsAbsentWithoutASolid) {
  ObstacleShape shape;
  shape.kind = ObstacleShape::Kind::Point;
  EXPECT_FALSE(triangle_distance({Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()}, {&shape, {}}));
}

}  // namespace
}  // namespace crease
