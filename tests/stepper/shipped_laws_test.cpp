// SPDX-License-Identifier: MIT
// Shipped scenes that have an exact answer, run as they ship.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "support/scene_run.hpp"

namespace crease {
namespace {

using namespace testing;

// x_n = x_0 + v_0 t + g t (t + h)/2, the law of the implicit step itself, for every vertex of an irregular mesh.
TEST(ShippedScene, FreeFallFollowsTheDiscreteLaw) {
  const std::vector<Frame> frames = run_shipped("free_fall", {}, "law");
  ASSERT_EQ(frames.size(), 31u);
  const Vec3 g(0, 0, -9.81), v0(0.5, 0, 2);
  const double h = 0.005;
  for (const Frame& frame : frames) {
    const double t = frame.time;
    const Vec3 path = v0 * t + g * t * (t + h) / 2;
    for (std::size_t v = 0; v < frame.x.size(); ++v)
      ASSERT_LE((frame.x[v] - frames[0].x[v] - path).norm(), 1e-12) << "t = " << t;  // 200 roundings of numbers about 3
  }
  EXPECT_EQ(frames.back().time, 1.0);
}

// At rest a point at U has moved down by rho g (L U - U^2/2)/E. Linear elements are exact there in the mean along a
// row: vertices of the lowest row that belong to more triangles carry more of its mass, and single ones deviate.
TEST(ShippedScene, HangingComesToRestWhereTheClosedFormIs) {
  const std::vector<Frame> frames = run_shipped("hanging", {}, "law");
  const double stretch = 0.05 * 9.81 / 50, width = 0.2;  // rho g/E [1/m]
  const Frame &last = frames.back(), &before = frames[frames.size() - 60];
  EXPECT_EQ(last.time, 2.0);
  struct Row {
    double deviation = 0, weight = 0;
  };
  std::map<long, Row> rows;  // by U in fortieths
  for (std::size_t v = 0; v < last.x.size(); ++v) {
    const double U = last.X[v].x(), V = last.X[v].y();
    const double deviation = last.x[v].z() - (1 - U - stretch * (U - U * U / 2));
    const double weight = V < 1e-9 || V > width - 1e-9 ? 0.5 : 1.0;  // of the integral along the row
    Row& row = rows[std::lround(40 * U)];
    row.deviation += weight * deviation;
    row.weight += weight;
    EXPECT_LE((last.x[v] - before.x[v]).norm(), 1e-12) << "not at rest, t = " << before.time;
    // The uneven mass of two corners, rho g l/E of an element l = L/40, shears an element by 1/100 of that.
    EXPECT_LE(std::abs(deviation), 1e-6);
  }
  ASSERT_EQ(rows.size(), 41u);
  // What is left is of second order in rho g l/E = 2.5e-4.
  for (const auto& [number, row] : rows) EXPECT_LE(std::abs(row.deviation / row.weight), 1e-8) << "row " << number;
}

}  // namespace
}  // namespace crease
