// SPDX-License-Identifier: MIT
#include "crease/geometry/distance.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace crease {
namespace {

using Rng = std::mt19937_64;

double uniform(Rng& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

Vec3 random_point(Rng& rng, double size = 1) {
  return {uniform(rng, -size, size), uniform(rng, -size, size), uniform(rng, -size, size)};
}

// The distance of two segments is convex in (s, t): for a fixed s the best t is a projection, and what remains is a
// convex function of s alone, minimised by ternary search. Shares nothing with the closed form under test.
double segment_distance_by_search(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  const auto at = [&](double s) {
    const Vec3 p = a0 + s * (a1 - a0), d = b1 - b0;
    const double t = std::min(1.0, std::max(0.0, d.dot(p - b0) / std::max(d.squaredNorm(), 1e-300)));
    return (p - b0 - t * d).norm();
  };
  double low = 0, high = 1;
  for (int i = 0; i < 200; ++i) {
    const double third = (high - low) / 3;
    if (at(low + third) < at(high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  return std::min({at(0), at(1), at(0.5 * (low + high))});
}

// Pattern search in (u, v): steps in twelve directions, halved when none is better.
double triangle_distance_by_search(const Vec3& p, const std::array<Vec3, 3>& x) {
  const auto at = [&](double u, double v) { return ((1 - u - v) * x[0] + u * x[1] + v * x[2] - p).norm(); };
  double u = 1.0 / 3, v = 1.0 / 3, step = 0.25, best = at(u, v);
  while (step > 1e-9) {
    bool moved = false;
    for (int i = 0; i < 12; ++i) {
      const double angle = i * M_PI / 6;
      double nu = std::max(0.0, u + step * std::cos(angle)), nv = std::max(0.0, v + step * std::sin(angle));
      if (nu + nv > 1) {
        const double excess = 0.5 * (nu + nv - 1);
        nu = std::min(1.0, std::max(0.0, nu - excess));
        nv = 1 - nu < nv ? 1 - nu : std::max(0.0, nv - excess);
      }
      if (at(nu, nv) < best) {
        best = at(nu, nv);
        u = nu;
        v = nv;
        moved = true;
      }
    }
    if (!moved) step *= 0.5;
  }
  return best;
}

void expect_consistent(const SegmentPair& pair, const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  EXPECT_GE(pair.s, 0);
  EXPECT_LE(pair.s, 1);
  EXPECT_GE(pair.t, 0);
  EXPECT_LE(pair.t, 1);
  EXPECT_NEAR(pair.distance, (a0 + pair.s * (a1 - a0) - b0 - pair.t * (b1 - b0)).norm(), 1e-14);
}

TEST(ClosestSegments, AgreeWithConvexSearchOnRandomPairs) {
  SCOPED_TRACE("seed 1");
  Rng rng(1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 a0 = random_point(rng), a1 = random_point(rng), b0 = random_point(rng), b1 = random_point(rng);
    const SegmentPair pair = closest_segments(a0, a1, b0, b1);
    expect_consistent(pair, a0, a1, b0, b1);
    // The search stops at 1e-16 in s, but its function is flat to 1e-8 there: distances near zero resolve to about
    // 1e-9.
    EXPECT_NEAR(pair.distance, segment_distance_by_search(a0, a1, b0, b1), 1e-8);
    EXPECT_FALSE(pair.parallel);
  }
}

// The nine regions of the parameter square: each of the two closest points is a start, an end or an inner point.
TEST(ClosestSegments, FindEveryRegion) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      // a runs along x with its closest point at s = i / 2; b runs along y, likewise; they are 0.25 apart in z.
      const Vec3 a0(-0.5 * i, 0, 0), a1(1 - 0.5 * i, 0, 0), b0(0, -0.5 * j, 0.25), b1(0, 1 - 0.5 * j, 0.25);
      const SegmentPair pair = closest_segments(a0, a1, b0, b1);
      EXPECT_NEAR(pair.s, 0.5 * i, 1e-15);
      EXPECT_NEAR(pair.t, 0.5 * j, 1e-15);
      EXPECT_NEAR(pair.distance, 0.25, 1e-15);
      // Pulled apart beyond the ends, the ends remain closest.
      const Vec3 shift(i == 0 ? 1 : i == 2 ? -1 : 0, 0, 0), shift_b(0, j == 0 ? 1 : j == 2 ? -1 : 0, 0);
      const SegmentPair apart = closest_segments(a0 + shift, a1 + shift, b0 + shift_b, b1 + shift_b);
      EXPECT_NEAR(apart.s, 0.5 * i, 1e-15);
      EXPECT_NEAR(apart.t, 0.5 * j, 1e-15);
      EXPECT_NEAR(apart.distance, std::sqrt(0.0625 + shift.squaredNorm() + shift_b.squaredNorm()), 1e-15);
    }
  }
}

TEST(ClosestSegments, AreExactForNearlyParallelPairs) {
  SCOPED_TRACE("seed 2");
  Rng rng(2);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 a0 = random_point(rng), a1 = random_point(rng), offset = random_point(rng);
    const double angle = std::pow(10.0, uniform(rng, -14, -2));
    const Vec3 b0 = a0 + offset, b1 = a1 + offset + angle * random_point(rng);
    const SegmentPair pair = closest_segments(a0, a1, b0, b1);
    expect_consistent(pair, a0, a1, b0, b1);
    EXPECT_NEAR(pair.distance, segment_distance_by_search(a0, a1, b0, b1), 1e-8);
  }
}

TEST(ClosestSegments, SayWhenDirectionsAreParallel) {
  const Vec3 a0(0, 0, 0), a1(2, 0, 0), up(0, 0, 1);
  EXPECT_TRUE(closest_segments(a0, a1, a0 + up, a1 + up).parallel);
  EXPECT_TRUE(closest_segments(a0, a1, a1 + up, a0 + up).parallel);
  EXPECT_TRUE(closest_segments(a0, a1, up, up).parallel) << "a segment without length has no direction";
  EXPECT_FALSE(closest_segments(a0, a1, up, up + Vec3(1, 1e-6, 0)).parallel);
  EXPECT_NEAR(closest_segments(a0, a1, a0 + up, a1 + up).distance, 1, 1e-15);
  EXPECT_NEAR(closest_segments(a0, a0, up, up).distance, 1, 1e-15);
}

TEST(ClosestOnTriangle, AgreesWithSearchOnRandomPoints) {
  SCOPED_TRACE("seed 3");
  Rng rng(3);
  for (int i = 0; i < 300; ++i) {
    const std::array<Vec3, 3> x{random_point(rng), random_point(rng), random_point(rng)};
    const Vec3 p = random_point(rng, 2);
    const Vec3 w = closest_on_triangle(p, x);
    EXPECT_NEAR(w.sum(), 1, 1e-14);
    EXPECT_GE(w.minCoeff(), 0);
    const double distance = (w[0] * x[0] + w[1] * x[1] + w[2] * x[2] - p).norm();
    // The search can stall on a side, so it is an upper bound; 1e-3 is a generous bound of its own error.
    EXPECT_LE(distance, triangle_distance_by_search(p, x) + 1e-12);
    EXPECT_NEAR(distance, triangle_distance_by_search(p, x), 1e-3);
  }
}

TEST(ClosestOnTriangle, FindsEveryVoronoiRegion) {
  const std::array<Vec3, 3> x{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const double z = 0.3;
  const auto expect = [&](const Vec3& p, const Vec3& w) { EXPECT_LE((closest_on_triangle(p, x) - w).norm(), 1e-14); };
  expect({0.2, 0.3, z}, {0.5, 0.2, 0.3});  // face
  expect({-1, -1, z}, {1, 0, 0});          // corners
  expect({3, -0.5, z}, {0, 1, 0});
  expect({-0.5, 3, -z}, {0, 0, 1});
  expect({0.4, -2, z}, {0.6, 0.4, 0});  // sides
  expect({1, 1, -z}, {0, 0.5, 0.5});
  expect({-2, 0.7, z}, {0.3, 0, 0.7});
}

TEST(ClosestOnTriangle, TakesADegenerateTriangleForItsSides) {
  const std::array<Vec3, 3> line{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(3, 0, 0)};
  const auto point = [&](const Vec3& p, const std::array<Vec3, 3>& x) {
    const Vec3 w = closest_on_triangle(p, x);
    return Vec3(w[0] * x[0] + w[1] * x[1] + w[2] * x[2]);
  };
  EXPECT_LE((point({2, 5, 0}, line) - Vec3(2, 0, 0)).norm(), 1e-14);
  EXPECT_LE((point({-2, 5, 0}, line) - Vec3(0, 0, 0)).norm(), 1e-14);
  const std::array<Vec3, 3> dot{Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1)};
  EXPECT_LE((point({2, 5, 0}, dot) - Vec3(1, 1, 1)).norm(), 1e-14);
  const std::array<Vec3, 3> sliver{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 1e-17, 0)};
  EXPECT_LE((point({0.7, 0, 1}, sliver) - Vec3(0.7, 0, 0)).norm(), 1e-12);
}

}  // namespace
}  // namespace crease
