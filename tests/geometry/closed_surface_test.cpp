// SPDX-License-Identifier: MIT
#include "crease/geometry/closed_surface.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "crease/geometry/distance.hpp"
#include "support/meshes.hpp"
#include "support/surfaces.hpp"

namespace crease {
namespace {

using support::Rng;
using support::uniform;

Vec3 random_point(Rng& rng, double size = 1) {
  return {uniform(rng, -size, size), uniform(rng, -size, size), uniform(rng, -size, size)};
}

double brute_distance(const TriangleSurface& surface, const Vec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [i, j, k] : surface.triangles) {
    const std::array<Vec3, 3> x{surface.vertices[i], surface.vertices[j], surface.vertices[k]};
    const Vec3 w = closest_on_triangle(p, x);
    nearest = std::min(nearest, (w[0] * x[0] + w[1] * x[1] + w[2] * x[2] - p).norm());
  }
  return support::winding_number(surface, p) > 0.5 ? -nearest : nearest;
}

// Oracle: every triangle, and the solid angle for the sign.
TEST(ClosedSurface, NearestIsTheNearestOfAllTrianglesWithTheSignOfTheSolidAngle) {
  SCOPED_TRACE("seed 1");
  Rng rng(1);
  for (const auto& [name, mesh] : support::all_surfaces()) {
    SCOPED_TRACE(name);
    const ClosedSurface surface(mesh);
    for (int i = 0; i < 1000; ++i) {
      const Vec3 p = random_point(rng, 1.5);
      const SurfaceFoot foot = surface.nearest(p);
      EXPECT_NEAR(foot.distance, brute_distance(mesh, p), 1e-14);
      EXPECT_NEAR((p - foot.point).norm(), std::abs(foot.distance), 1e-14);
    }
  }
}

// Points on the surface, its edges and vertices, and where several triangles are equally near: in the middle planes and
// on the diagonals of a box, on the axes of a ball.
std::vector<Vec3> points_with_ties(const TriangleSurface& mesh, Rng& rng) {
  std::vector<Vec3> points = mesh.vertices;
  for (const Vec3& x : mesh.vertices) points.insert(points.end(), {0.5 * x, 1.25 * x, x.cwiseProduct(Vec3(1, 1, 0))});
  for (int i = 0; i < 300; ++i) {
    const auto& t = mesh.triangles[support::pick(rng, static_cast<int>(mesh.triangles.size()))];
    const double s = uniform(rng, 0, 1), r = i % 3 == 0 ? 0 : uniform(rng, 0, 1 - s);
    points.push_back((1 - s - r) * mesh.vertices[t[0]] + s * mesh.vertices[t[1]] + r * mesh.vertices[t[2]]);
    points.push_back(random_point(rng, 1.5));
    points.push_back(points.back().cwiseProduct(Vec3(i % 2, 1, 0)));
    points.push_back(Vec3::Constant(uniform(rng, -1, 1)));
  }
  return points;
}

// Oracle: all triangles in turn, by the same sums, so to the last bit. Once the box of a triangle that was nearer by
// round-off, and lower, was passed over: which of several equals came out hung on where the search began.
TEST(ClosedSurface, NearestIsTheSameFromEveryStart) {
  SCOPED_TRACE("seed 4");
  Rng rng(4);
  auto surfaces = support::all_surfaces();
  auto thin = support::ball_surface(1, 3);  // and triangles like needles
  for (Vec3& x : thin.vertices) x = x.cwiseProduct(Vec3(1e-6, 0.7, 1e-3));
  surfaces.emplace_back("thin", thin);
  for (const auto& [name, mesh] : surfaces) {
    SCOPED_TRACE(name);
    const ClosedSurface surface(mesh);
    const auto n = static_cast<int>(mesh.triangles.size());
    for (const Vec3& p : points_with_ties(mesh, rng)) {
      int nearest = -1;
      double least = std::numeric_limits<double>::infinity();
      for (int t = 0; t < n; ++t) {
        const auto& [i, j, k] = mesh.triangles[t];
        const std::array<Vec3, 3> x{mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]};
        const Vec3 w = closest_on_triangle(p, x), on = w[0] * x[0] + w[1] * x[1] + w[2] * x[2];
        const double d = (p - on).norm();
        if (d * d < least) least = d * d, nearest = t;
      }
      const SurfaceFoot foot = surface.nearest(p);
      ASSERT_EQ(foot.triangle, nearest) << p.transpose();
      ASSERT_EQ(foot.distance * foot.distance, least) << p.transpose();
      for (int i = 0; i < 5; ++i) {
        const SurfaceFoot again = surface.nearest(p, support::pick(rng, n));
        ASSERT_EQ(again.triangle, nearest) << p.transpose();
        ASSERT_EQ(again.distance, foot.distance);
        ASSERT_EQ(again.point, foot.point);
        ASSERT_EQ(again.normal, foot.normal);
      }
    }
  }
}

// Where the nearest point is a vertex or an edge no face's own normal gives the sign: points close to them, all round.
TEST(ClosedSurface, TellsInsideFromOutsideAtEdgesAndVertices) {
  SCOPED_TRACE("seed 2");
  Rng rng(2);
  for (const auto& [name, mesh] : support::all_surfaces()) {
    SCOPED_TRACE(name);
    const ClosedSurface surface(mesh);
    for (int i = 0; i < 1000; ++i) {
      const auto& t = mesh.triangles[support::pick(rng, static_cast<int>(mesh.triangles.size()))];
      const double s = i % 2 == 0 ? 0 : uniform(rng, 0, 1);
      const Vec3 on = (1 - s) * mesh.vertices[t[0]] + s * mesh.vertices[t[1]];
      const Vec3 p = on + 1e-3 * random_point(rng);
      EXPECT_EQ(surface.nearest(p).distance<0, support::winding_number(mesh, p)> 0.5);
    }
  }
}

TEST(ClosedSurface, HasOneMinimumOutsideAConvexSolidAndTheNearestInside) {
  SCOPED_TRACE("seed 3");
  Rng rng(3);
  for (const auto& [name, mesh] : support::all_surfaces()) {
    SCOPED_TRACE(name);
    const ClosedSurface surface(mesh);
    EXPECT_EQ(surface.is_convex(), name != "l" && name != "quartered l");
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = random_point(rng, 1.5);
      const SurfaceFoot nearest = surface.nearest(p);
      const auto minima = surface.minima(p, 10);
      ASSERT_FALSE(minima.empty());
      if (surface.is_convex() || nearest.distance < 0) {
        ASSERT_EQ(minima.size(), 1u);
        EXPECT_EQ(minima[0].point, nearest.point);
      }
      const auto closest =
          std::min_element(minima.begin(), minima.end(), [](auto& a, auto& b) { return a.distance < b.distance; });
      EXPECT_EQ(closest->distance, nearest.distance);
      EXPECT_TRUE(surface.minima(p, nearest.distance - 1e-6).empty());
    }
  }
}

// l_surface() has its groove along x at y = z = 0: the two faces there are z = 0, y > 0 and y = 0, z > 0.
TEST(ClosedSurface, HasOneMinimumOnEachSideOfAGroove) {
  for (const auto& mesh : {support::l_surface(), support::quartered(support::l_surface())}) {
    const ClosedSurface surface(mesh);
    const auto minima = surface.minima({0.1, 0.02, 0.03}, 0.1);
    ASSERT_EQ(minima.size(), 2u);
    EXPECT_NEAR(std::min(minima[0].distance, minima[1].distance), 0.02, 1e-15);
    EXPECT_NEAR(std::max(minima[0].distance, minima[1].distance), 0.03, 1e-15);
    EXPECT_NEAR(minima[0].normal.dot(minima[1].normal), 0, 1e-15);
    EXPECT_EQ(surface.minima({0.1, 0.02, 0.03}, 0.025).size(), 1u);
  }
}

// Two parts, each convex: together they are not.
TEST(ClosedSurface, OfTwoPartsIsNotConvex) {
  TriangleSurface two = support::box_surface({1, 1, 1});
  const TriangleSurface one = two;
  for (const Vec3& p : one.vertices) two.vertices.push_back(p + Vec3(1.1, 0, 0));
  for (const auto& [a, b, c] : one.triangles) two.triangles.push_back({a + 8, b + 8, c + 8});
  const ClosedSurface surface(two);
  EXPECT_FALSE(surface.is_convex());
  EXPECT_EQ(surface.minima({0.54, 0, 0}, 0.1).size(), 2u);
}

void expect_problem(const TriangleSurface& surface, const std::string& says) {
  const auto problems = surface_problems(surface);
  ASSERT_FALSE(problems.empty()) << says;
  EXPECT_NE(problems[0].find(says), std::string::npos) << problems[0];
  EXPECT_THROW(ClosedSurface{surface}, std::invalid_argument);
  EXPECT_THROW(make_mesh(surface, 0.5), std::invalid_argument);
}

TEST(SurfaceProblems, AreNoneForSolids) {
  for (const auto& [name, mesh] : support::all_surfaces()) EXPECT_EQ(surface_problems(mesh).size(), 0u) << name;
}

TEST(SurfaceProblems, NameWhatIsWrong) {
  const TriangleSurface box = support::box_surface({1, 1, 1});
  expect_problem({}, "has no triangles");
  TriangleSurface broken = box;
  broken.triangles.pop_back();
  expect_problem(broken, "is not closed");
  EXPECT_NE(surface_problems(broken)[0].find("and 2 more like it"), std::string::npos);
  broken = box;
  std::swap(broken.triangles[3][0], broken.triangles[3][1]);
  expect_problem(broken, "disagree about the outside");
  broken = box;
  for (auto& t : broken.triangles) std::swap(t[0], t[1]);
  expect_problem(broken, "inside out");
  broken = box;
  broken.triangles.push_back({0, 1, 8});
  expect_problem(broken, "triangle 13 names a vertex that does not exist");
  broken.vertices.emplace_back(0, 0, std::numeric_limits<double>::quiet_NaN());
  expect_problem(broken, "triangle 13 has a corner that is not finite");
  broken.vertices.back() = 0.25 * broken.vertices[0] + 0.75 * broken.vertices[1];
  expect_problem(broken, "triangle 13 has no area");
  broken.vertices.back() = {0, 0, 3};
  expect_problem(broken, "is not closed");
}

// Two tetrahedra that share an edge, and two that share a vertex.
TEST(SurfaceProblems, NameWhereASolidIsPinched) {
  const std::vector<std::array<int, 3>> faces{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  TriangleSurface one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, faces};
  ASSERT_TRUE(surface_problems(one).empty());
  // Mirrored through a point of the edge 0-3 or through vertex 0: the orientation of the copy is that of its mirror.
  TriangleSurface edge = one;
  edge.vertices.insert(edge.vertices.end(), {{-1, 0, 0}, {0, -1, 0}});
  for (auto [a, b, c] : faces) {
    const auto id = [](int i) { return i == 1 ? 4 : i == 2 ? 5 : i; };
    edge.triangles.push_back({id(a), id(b), id(c)});
  }
  expect_problem(edge, "joins 4 triangles");
  TriangleSurface tip = one;
  tip.vertices.insert(tip.vertices.end(), {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
  for (auto [a, b, c] : faces) {
    const auto id = [](int i) { return i == 0 ? 0 : i + 3; };
    tip.triangles.push_back({id(a), id(c), id(b)});
  }
  expect_problem(tip, "vertex 1 joins two parts");
}

}  // namespace
}  // namespace crease
