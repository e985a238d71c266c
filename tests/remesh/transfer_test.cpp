// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/remesh/remesh.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

using support::Rng;
using support::uniform;

Mat32 random_gradient(Rng& rng) {
  Mat32 F;
  for (int i = 0; i < 6; ++i) F(i / 2, i % 2) = uniform(rng, -1, 1);
  return F;
}

Vec3 random_velocity(Rng& rng) {
  return {uniform(rng, -3, 3), uniform(rng, -3, 3), uniform(rng, -3, 3)};
}

// Golden section on the constraint line: knows nothing of normal equations.
double minimum_along(const Vec2& direction, const Mat32& F, const Vec3& w) {
  const auto cost = [&](double s) { return (w + s * (F * direction)).squaredNorm(); };
  double lo = -1e4, hi = 1e4;
  const double ratio = 0.5 * (std::sqrt(5.0) - 1);
  for (int i = 0; i < 200; ++i) {
    const double a = hi - ratio * (hi - lo), b = lo + ratio * (hi - lo);
    (cost(a) < cost(b) ? hi : lo) = cost(a) < cost(b) ? b : a;
  }
  return 0.5 * (lo + hi);
}

TEST(EulerianShare, AgreesWithALineSearchUnderOneRow) {
  Rng rng(3);
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE("case " + std::to_string(i));
    const Mat32 F = random_gradient(rng);
    const Vec3 w = random_velocity(rng);
    const double angle = uniform(rng, 0, 7);
    const Vec2 row(std::cos(angle), std::sin(angle)), free(-row.y(), row.x());
    const Vec2 V = eulerian_share(w, F, std::array{row});
    const double scale = 1 + V.norm();
    EXPECT_LE(std::abs(row.dot(V)), 1e-14 * scale);
    // A minimum is flat: a line search finds its place to the square root of the rounding unit only.
    EXPECT_NEAR(free.dot(V), minimum_along(free, F, w), 1e-5 * scale);
    EXPECT_LE(std::abs((w + F * V).dot(F * free)), 1e-12 * scale);
  }
}

TEST(EulerianShare, LeavesNothingTangentialWithoutRows) {
  Rng rng(4);
  for (int i = 0; i < 100; ++i) {
    const Mat32 F = random_gradient(rng);
    const Vec3 w = random_velocity(rng);
    const Vec2 V = eulerian_share(w, F, {});
    // The residual is normal to the sheet; conditioning of F^T F for random F.
    EXPECT_LE((F.transpose() * (w + F * V)).norm(), 1e-9 * (1 + V.norm()));
  }
}

TEST(EulerianShare, IsZeroUnderTwoIndependentRowsAndOneUnderTwoEqualOnes) {
  Rng rng(5);
  const Mat32 F = random_gradient(rng);
  const Vec3 w = random_velocity(rng);
  const Vec2 a(0.6, 0.8), b(1, 0);
  EXPECT_EQ(eulerian_share(w, F, std::array{a, b}), Vec2::Zero());
  EXPECT_LE((eulerian_share(w, F, std::array{a, Vec2(-a)}) - eulerian_share(w, F, std::array{a})).norm(), 1e-15);
}

TEST(EulerianShare, IsBoundedWhereTheSheetIsCrushed) {
  const Vec3 w(1, 2, 3);
  Mat32 F = Mat32::Zero();
  EXPECT_EQ(eulerian_share(w, F, {}), Vec2::Zero());
  F.col(0) = Vec3(1, 0, 0);  // the second direction has no image
  EXPECT_TRUE(eulerian_share(w, F, {}).isApprox(Vec2(-1, 0)));
  EXPECT_EQ(eulerian_share(w, F, std::array{Vec2(1, 0)}), Vec2::Zero());
}

}  // namespace
}  // namespace crease
