// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/geometry/obstacle.hpp"
#include "support/meshes.hpp"
#include "support/surfaces.hpp"

namespace crease {
namespace {

using support::Rng;
using support::uniform;

constexpr double degree = std::numbers::pi / 180;

bool same_set(std::vector<Vec3> a, const std::vector<Vec3>& b, double tolerance) {
  if (a.size() != b.size()) return false;
  return std::all_of(b.begin(), b.end(), [&](const Vec3& p) {
    const auto at = std::find_if(a.begin(), a.end(), [&](const Vec3& q) { return (p - q).norm() <= tolerance; });
    if (at == a.end()) return false;
    a.erase(at);
    return true;
  });
}

// Number of features of `mesh` that have their like in `box`.
void expect_same_features(const ObstacleShape& mesh, const ObstacleShape& box, double tolerance) {
  ASSERT_EQ(mesh.corners.size(), box.corners.size());
  ASSERT_EQ(mesh.edges.size(), box.edges.size());
  for (const SharpCorner& c : mesh.corners)
    EXPECT_EQ(std::count_if(box.corners.begin(), box.corners.end(),
                            [&](const SharpCorner& other) {
                              return (c.position - other.position).norm() <= tolerance &&
                                     same_set(c.normals, other.normals, tolerance);
                            }),
              1);
  for (const SharpEdge& e : mesh.edges) {
    EXPECT_EQ(std::count_if(box.edges.begin(), box.edges.end(),
                            [&](const SharpEdge& other) {
                              return same_set({e.a, e.b}, {other.a, other.b}, tolerance) &&
                                     same_set({e.normals[0], e.normals[1]}, {other.normals[0], other.normals[1]},
                                              tolerance);
                            }),
              1);
    EXPECT_LE((mesh.corners[e.corners[0]].position - e.a).norm(), 0);
    EXPECT_LE((mesh.corners[e.corners[1]].position - e.b).norm(), 0);
  }
}

TEST(MakeMesh, OfABoxHasTheFeaturesOfTheBox) {
  const Vec3 size(0.4, 1.0, 0.6);
  const ObstacleShape box = make_box(size);
  TriangleSurface surface = support::box_surface(size);
  for (int round = 0; round < 3; ++round) {
    const ObstacleShape mesh = make_mesh(surface, 30 * degree);
    expect_same_features(mesh, box, 0);
    EXPECT_EQ(mesh.planes.size(), 6u);
    surface = support::quartered(surface);
  }
}

// The same in any position and with coordinates of six decimals, as files hold them.
TEST(MakeMesh, OfATurnedAndRoundedBoxHasTheFeaturesOfTheBox) {
  SCOPED_TRACE("seed 1");
  Rng rng(1);
  const Vec3 size(0.4, 1.0, 0.6);
  for (int i = 0; i < 20; ++i) {
    const Mat3 R = Eigen::AngleAxisd(uniform(rng, 0, 3), Vec3(uniform(rng, -1, 1), 1, 0.3).normalized()).matrix();
    ObstacleShape box = make_box(size);
    for (SharpCorner& c : box.corners) {
      c.position = R * c.position;
      for (Vec3& n : c.normals) n = R * n;
    }
    for (SharpEdge& e : box.edges) e.a = R * e.a, e.b = R * e.b, e.normals = {R * e.normals[0], R * e.normals[1]};
    TriangleSurface surface = support::quartered(support::box_surface(size));
    for (Vec3& p : surface.vertices) p = R * p;
    expect_same_features(make_mesh(surface, 30 * degree), box, 1e-15);
    for (Vec3& p : surface.vertices) p = (1e6 * p).array().round().matrix() / 1e6;
    // Half of the last decimal over triangles of .2 m turns a normal by 5e-6.
    expect_same_features(make_mesh(surface, 30 * degree), box, 1e-5);
  }
}

TEST(MakeMesh, MakesAnEdgeOfEveryAngleUpToTheSharpOne) {
  for (const double angle : {20, 40, 60, 90, 120, 149, 151}) {
    SCOPED_TRACE(angle);
    const ObstacleShape ridge = make_mesh(support::quartered(support::ridge_surface(angle * degree, 2)), 30 * degree);
    const auto top = std::find_if(ridge.edges.begin(), ridge.edges.end(),
                                  [](const SharpEdge& e) { return e.a.tail<2>().isZero() && e.b.tail<2>().isZero(); });
    ASSERT_EQ(top != ridge.edges.end(), angle < 150);
    EXPECT_EQ(ridge.edges.size(), angle < 150 ? 9u : 8u);
    EXPECT_EQ(ridge.blunt_edges.size(), angle < 150 ? 0u : 2u) << "one a mesh edge";
    // A corner stays one without the ridge: its sheet still bends by 90 degrees there.
    EXPECT_EQ(ridge.corners.size(), 6u);
    if (top == ridge.edges.end()) continue;
    EXPECT_NEAR(top->normals[0].dot(top->normals[1]), -std::cos(angle * degree), 1e-14);
    const double c = std::cos(angle / 2 * degree), s = std::sin(angle / 2 * degree);
    EXPECT_TRUE(same_set({top->normals[0], top->normals[1]}, {{0, c, s}, {0, -c, s}}, 1e-14));
    EXPECT_TRUE(same_set(ridge.corners[top->corners[0]].normals,
                         {{0, c, s}, {0, -c, s}, {top->a.x() < 0 ? -1.0 : 1.0, 0, 0}}, 1e-14));
  }
}

// Of the L only the edge at the origin bends inwards; where it ends, nothing can rest but flat on the side.
TEST(MakeMesh, MakesNothingOfAnEdgeThatBendsInwards) {
  for (const auto& surface : {support::l_surface(), support::quartered(support::l_surface())}) {
    const ObstacleShape l = make_mesh(surface, 30 * degree);
    EXPECT_EQ(l.edges.size(), 17u);
    EXPECT_EQ(l.corners.size(), 10u);
    EXPECT_TRUE(l.planes.empty());
    for (const SharpCorner& c : l.corners) EXPECT_GT(c.position.tail<2>().norm(), 0.5);
    int ends = 0;
    for (const SharpEdge& e : l.edges)
      for (const int k : {0, 1}) {
        const Vec3& end = k == 0 ? e.a : e.b;
        EXPECT_EQ(e.corners[k] < 0, end.tail<2>().isZero());
        ends += e.corners[k] < 0;
      }
    EXPECT_EQ(ends, 4);
  }
}

TEST(MakeMesh, MakesNoFeatureOfARoundSurface) {
  const ObstacleShape ball = make_mesh(support::ball_surface(1, 3), 30 * degree);
  EXPECT_TRUE(ball.edges.empty());
  EXPECT_EQ(ball.blunt_edges.size(), 512u * 3 / 2);
  EXPECT_TRUE(ball.corners.empty());
  EXPECT_TRUE(ball.planes.empty()) << "512 faces are no list of planes";
  EXPECT_EQ(std::set<int>(ball.patch.begin(), ball.patch.end()).size(), 1u);
}

// A drum: its two rims are polygons whose every corner bends the rim a little.
TEST(MakeMesh, MakesAPolygonOfARim) {
  std::vector<Vec2> circle;
  constexpr int n = 24;
  for (int k = 0; k < n; ++k)
    circle.emplace_back(std::cos(2 * std::numbers::pi * k / n), std::sin(2 * std::numbers::pi * k / n));
  const ObstacleShape drum = make_mesh(support::prism_surface(circle, 1), 30 * degree);
  EXPECT_EQ(drum.edges.size(), 2u * n);
  EXPECT_EQ(drum.corners.size(), 2u * n);
  for (const SharpCorner& c : drum.corners) EXPECT_EQ(c.normals.size(), 3u);
  EXPECT_EQ(std::set<int>(drum.patch.begin(), drum.patch.end()).size(), 3u);
  EXPECT_EQ(make_mesh(support::prism_surface(circle, 1), 10 * degree).edges.size(), 3u * n) << "15 degrees a side";
}

// What makes a cone a cone of normals: no vertex of the solid is above the plane through the feature.
TEST(MakeMesh, GivesNormalsThatSupportTheSolidThere) {
  SCOPED_TRACE("seed 2");
  Rng rng(2);
  for (const auto& [name, surface] : support::all_surfaces()) {
    SCOPED_TRACE(name);
    const ObstacleShape shape = make_mesh(surface, 30 * degree);
    const auto deepest_above = [&](const Vec3& n, const Vec3& p) {
      double above = -1;
      // Near the feature only: an L is not convex.
      for (int i = 0; i < 200; ++i) {
        const Vec3 q = p + 1e-3 * Vec3(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
        if (*signed_distance(shape, {}, q) < 0) above = std::max(above, n.dot(q - p));
      }
      return above;
    };
    for (const SharpCorner& c : shape.corners)
      for (const Vec3& n : c.normals) EXPECT_LE(deepest_above(n, c.position), 1e-12);
    for (const SharpEdge& e : shape.edges)
      for (const Vec3& n : e.normals) EXPECT_LE(deepest_above(n, 0.3 * e.a + 0.7 * e.b), 1e-12);
  }
}

TEST(MakeMesh, DropsVerticesOfNoTriangle) {
  TriangleSurface surface = support::box_surface({1, 1, 1});
  surface.vertices.insert(surface.vertices.begin(), Vec3(9, 9, 9));
  for (auto& t : surface.triangles)
    for (int& i : t) ++i;
  const ObstacleShape mesh = make_mesh(surface, 30 * degree);
  EXPECT_EQ(mesh.vertices.size(), 8u);
  expect_same_features(mesh, make_box({1, 1, 1}), 0);
  EXPECT_THROW(make_mesh(surface, 0), std::invalid_argument);
}

}  // namespace
}  // namespace crease
