// SPDX-License-Identifier: MIT
#include "crease/geometry/triangle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "support/meshes.hpp"

namespace crease {
namespace {

using support::Rng;
using support::uniform;

std::array<Vec2, 3> random_material(Rng& rng) {
  while (true) {
    std::array<Vec2, 3> X;
    for (Vec2& P : X) P = Vec2(uniform(rng, -1, 1), uniform(rng, -1, 1));
    if (orient2d(X[0], X[1], X[2]) > 0.2) return X;
  }
}

std::array<Vec3, 3> random_world(Rng& rng) {
  std::array<Vec3, 3> x;
  for (Vec3& p : x) p = Vec3(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
  return x;
}

TEST(Orient2d, HasTheExactSignOnAFineLattice) {
  // Points about a line, one last place apart: with coordinates k / 2^53 the determinant is an integer over 2^106.
  __extension__ using Wide = __int128;
  const auto exact = [](const std::array<std::array<std::int64_t, 2>, 3>& k) {
    const Wide left = static_cast<Wide>(k[0][0] - k[2][0]) * (k[1][1] - k[2][1]);
    const Wide right = static_cast<Wide>(k[0][1] - k[2][1]) * (k[1][0] - k[2][0]);
    return left > right ? 1 : (left < right ? -1 : 0);
  };
  const std::int64_t half = std::int64_t{1} << 52, far = 12 * (std::int64_t{1} << 50), farther = 24 * (far / 12);
  int zeros = 0;
  for (std::int64_t i = 0; i < 64; ++i) {
    for (std::int64_t j = 0; j < 64; ++j) {
      const std::array<std::array<std::int64_t, 2>, 3> k = {
          {{half + 2 * i, half + 2 * j}, {far, far}, {farther, farther}}};
      std::array<Vec2, 3> P;
      for (int n = 0; n < 3; ++n) P[n] = Vec2(std::ldexp(k[n][0], -53), std::ldexp(k[n][1], -53));
      const double value = orient2d(P[0], P[1], P[2]);
      EXPECT_EQ((value > 0) - (value < 0), exact(k));
      EXPECT_EQ(orient2d(P[1], P[0], P[2]) > 0, value < 0);
      EXPECT_EQ(orient2d(P[1], P[2], P[0]) > 0, value > 0);
      zeros += value == 0 ? 1 : 0;
    }
  }
  EXPECT_EQ(zeros, 64);
}

TEST(Orient2d, IsTwiceTheArea) {
  EXPECT_EQ(orient2d({0, 0}, {2, 0}, {0, 3}), 6);
  EXPECT_EQ(orient2d({0, 0}, {0, 3}, {2, 0}), -6);
  EXPECT_EQ(orient2d({0.1, 0.1}, {0.1, 0.1}, {0.7, 0.3}), 0);
}

TEST(Orient2d, IsNeverPositiveForNumbersThatAreNotFinite) {
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(orient2d({0, 0}, {inf, 0}, {0, inf}) > 0);
  EXPECT_FALSE(orient2d({0, 0}, {1, 0}, {0, std::nan("")}) > 0);
}

TEST(DeformationGradient, IsDxTimesInverseDX) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const auto X = random_material(rng);
    const auto x = random_world(rng);
    Mat2 DX;
    DX << X[1] - X[0], X[2] - X[0];
    Mat32 Dx;
    Dx << x[1] - x[0], x[2] - x[0];
    // Entries below 2, condition of DX below 50: a few rounding errors of that product.
    EXPECT_LT((deformation_gradient(X, x) - Dx * DX.inverse()).norm(), 1e-13);
  }
}

TEST(DeformationGradient, OfARigidMotionIsItsRotation) {
  Rng rng(7);
  const auto X = random_material(rng);
  const Mat3 R = Eigen::AngleAxisd(0.8, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  std::array<Vec3, 3> x;
  for (int i = 0; i < 3; ++i) x[i] = R * Vec3(X[i].x(), X[i].y(), 0) + Vec3(5, 6, 7);
  EXPECT_LT((deformation_gradient(X, x) - R.leftCols<2>()).norm(), 1e-14);
}

TEST(BarycentricGradients, AreTheDerivativesOfBarycentricCoordinates) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const auto X = random_material(rng);
    const Mat32 g = barycentric_gradients(X);
    const Vec2 P(uniform(rng, -1, 1), uniform(rng, -1, 1));
    // Barycentric coordinates are linear: a central difference of any width is exact.
    const double width = 0.5;
    for (int k = 0; k < 2; ++k) {
      const Vec2 step = width * Vec2::Unit(k);
      const Vec3 slope = (barycentric(X, P + step) - barycentric(X, P - step)) / (2 * width);
      EXPECT_LT((slope - g.col(k)).norm(), 1e-12);
    }
    EXPECT_LT(g.colwise().sum().norm(), 1e-13);
  }
}

TEST(Barycentric, ReproducesThePointAndSumsToOne) {
  Rng rng(11);
  for (int n = 0; n < 100; ++n) {
    const auto X = random_material(rng);
    const Vec2 P(uniform(rng, -2, 2), uniform(rng, -2, 2));
    const Vec3 b = barycentric(X, P);
    EXPECT_NEAR(b.sum(), 1, 1e-13);
    EXPECT_LT((b[0] * X[0] + b[1] * X[1] + b[2] * X[2] - P).norm(), 1e-13);
  }
  const std::array<Vec2, 3> X = {{{0, 0}, {1, 0}, {0, 1}}};
  EXPECT_EQ(barycentric(X, X[1]), Vec3(0, 1, 0));
  EXPECT_EQ(barycentric(X, Vec2(0.5, 0)), Vec3(0.5, 0.5, 0));
}

TEST(VertexDeformationGradient, WeighsFacesByArea) {
  for (const auto& [name, flat] : support::all_meshes()) {
    SCOPED_TRACE(name);
    Mesh mesh = flat;
    Rng rng(3);
    support::crumple(mesh, rng);
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      Mat32 sum = Mat32::Zero();
      double area = 0;
      for (int f = 0; f < mesh.n_faces(); ++f) {
        const auto& corners = mesh.face(f);
        if (std::find(corners.begin(), corners.end(), v) == corners.end()) continue;
        sum += mesh.material_area(f) * deformation_gradient(mesh, f);
        area += mesh.material_area(f);
      }
      EXPECT_LT((vertex_deformation_gradient(mesh, v) - sum / area).norm(), 1e-13);
    }
  }
}

TEST(FaceNormal, FollowsTheCornerOrderAndIsZeroOnANeedle) {
  std::vector<Vec2> X = {{0, 0}, {1, 0}, {0, 1}};
  std::vector<Vec3> x = {{0, 0, 0}, {2, 0, 0}, {0, 0, 3}};
  EXPECT_EQ(face_normal(Mesh(X, x, {{0, 1, 2}}), 0), Vec3(0, -1, 0));
  x[2] = Vec3(0.1, 0.2, 0.3);
  x[1] = 7 * x[2];
  EXPECT_EQ(face_normal(Mesh(X, x, {{0, 1, 2}}), 0), Vec3(0, 0, 0));
  x[1] = x[2] = x[0];
  EXPECT_EQ(face_normal(Mesh(X, x, {{0, 1, 2}}), 0), Vec3(0, 0, 0));
}

TEST(SmallestAngleAndAltitude, AreThoseOfKnownTriangles) {
  const std::array<Vec2, 3> right = {{{0, 0}, {4, 0}, {0, 3}}};
  EXPECT_NEAR(smallest_angle(right), std::atan2(3, 4), 1e-15);
  EXPECT_NEAR(smallest_altitude(right), 12.0 / 5, 1e-15);
  const std::array<Vec2, 3> obtuse = {{{0, 0}, {2, 0}, {-1, std::sqrt(3.0)}}};  // isosceles, 120 degrees at the origin
  EXPECT_NEAR(smallest_angle(obtuse), std::numbers::pi / 6, 1e-15);
  const std::array<Vec2, 3> needle = {{{0, 0}, {1, 0}, {1, 1e-9}}};
  EXPECT_NEAR(smallest_angle(needle), 1e-9, 1e-23);
  EXPECT_NEAR(smallest_altitude(needle), 1e-9, 1e-23);
}

}  // namespace
}  // namespace crease
