// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "support/strip_run.hpp"

namespace crease {
namespace {

using namespace crease::testing;  // the strip and its runs

TEST(Strip, FollowsTheExactSlideOverTheEdge) {
  const Strip strip;
  const double h = 2e-3;
  for (const GridPattern pattern : {GridPattern::Alternating, GridPattern::Cross, GridPattern::Right}) {
    StripSetup setup{strip};
    setup.pattern = pattern;
    const StripRun run = run_strip(setup, h, strip.lift_time());
    // 3e-5 L: nine times what a one-dimensional strand of the same scheme reaches at 2 ms; the rest is the strain
    // rho g L/E, times the .043 of the exact extensible solution.
    EXPECT_LE(shifted_error(run, strip, h), 3e-5 + 0.05 * strip.rho * strip.g * strip.L / strip.E);
  }
}

TEST(Strip, ConvergesWithFirstOrderAndWithSecondAfterTheHalfStepShift) {
  StripSetup setup{Strip{}};
  setup.strip.E = 1e6;    // rho g L/E = 1e-6: the strain does not hide the order
  setup.cells = {10, 2};  // wide enough elements that no step is cut, which would change its h
  const StripRun coarse = run_strip(setup, 4e-3, 0.37), fine = run_strip(setup, 2e-3, 0.37);
  ASSERT_EQ(coarse.cuts + fine.cuts, 0);
  const double shifted = std::log2(shifted_error(coarse, setup.strip, 4e-3) / shifted_error(fine, setup.strip, 2e-3));
  const double plain = std::log2(shifted_error(coarse, setup.strip, 0) / shifted_error(fine, setup.strip, 0));
  EXPECT_GE(shifted, 1.9);
  EXPECT_LE(shifted, 2.1);
  EXPECT_GE(plain, 0.95);
  EXPECT_LE(plain, 1.05);
}

TEST(Strip, EdgeReactionCarriesTheMomentumFlux) {
  const Strip strip;
  const double h = 1e-3;
  const StripRun run = run_strip({strip}, h, strip.lift_time());
  EXPECT_LE(reaction_error(run, strip, h), 1e-3);
}

TEST(Strip, LeavesTheEdgeWhenTensionIsTheMomentumFlux) {
  const Strip strip;
  const double h = 1e-3;
  const StripRun run = run_strip({strip}, h, 0.6);
  ASSERT_GT(run.lift_overhang, 0);
  EXPECT_NEAR(run.lift_overhang, strip.lift_overhang(), 4 * h);  // first order in h; 4 h in metres for L = 1 m
}

TEST(Strip, SlidesUniformlyAlongTheEdge) {
  // Linear elements leave a ripple across the strip in proportion to its strain (1e-8 m/s at 1e7 N/m): at 1e8 N/m what
  // remains beyond that tenth of it, and half as much again, would be an error of the rules at the border.
  StripSetup setup{Strip{}};
  setup.strip.E = 1e8;
  const StripRun run = run_strip(setup, 2e-3, 0.36);
  for (const Sample& s : run.samples) EXPECT_LE(s.spread, 1.5e-9) << s.time;
}

Mat3 random_turn(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

TEST(Strip, IsTheSameInATurnedScene) {
  // Remeshing has begun: of equals, rounding chooses which goes first, and so the numbering. Hence by place.
  const StripRun a = run_strip({Strip{}}, 2e-3, 0.36);
  std::mt19937_64 random{8};
  for (int scene = 0; scene < 5; ++scene) {
    StripSetup turned{Strip{}};
    turned.turn = random_turn(random);
    const StripRun b = run_strip(turned, 2e-3, 0.36);
    ASSERT_EQ(a.samples.size(), b.samples.size());
    for (std::size_t i = 0; i < a.samples.size(); ++i) {
      EXPECT_NEAR(a.samples[i].overhang, b.samples[i].overhang, 1e-9);
      EXPECT_LE((a.samples[i].reaction - b.samples[i].reaction).norm(), 1e-9);
    }
    ASSERT_EQ(a.last.mesh.n_vertices(), b.last.mesh.n_vertices());
    for (int v = 0; v < a.last.mesh.n_vertices(); ++v) {
      const auto less = [&](const Vec2& p, const Vec2& q) {
        return (p - a.last.mesh.X[v]).norm() < (q - a.last.mesh.X[v]).norm();
      };
      const auto twin = std::ranges::min_element(b.last.mesh.X, less) - b.last.mesh.X.begin();
      EXPECT_LE((a.last.mesh.X[v] - b.last.mesh.X[twin]).norm(), 1e-9) << v;
      EXPECT_LE((turned.turn * a.last.mesh.x[v] - b.last.mesh.x[twin]).norm(), 1e-9) << v;
      EXPECT_LE((turned.turn * a.last.v[v] - b.last.v[twin]).norm(), 1e-9) << v;
    }
  }
}

TEST(Strip, IsTheSameOnAMovingTable) {
  StripSetup moving{Strip{}};
  moving.drift = {6, -8, 3};  // over 10 m/s; a step of 2 ms carries everything by a third of an element
  const StripRun a = run_strip({Strip{}}, 2e-3, 0.36), b = run_strip(moving, 2e-3, 0.36);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t i = 0; i < a.samples.size(); ++i) EXPECT_NEAR(a.samples[i].overhang, b.samples[i].overhang, 1e-9);
}

TEST(Strip, FindsTheLineByCollisionAndRemeshing) {
  const Strip strip;
  StripSetup setup{strip};
  setup.mark_fold = false;
  EXPECT_LE(shifted_error(run_strip(setup, 2e-3, strip.lift_time()), strip, 2e-3), 1e-3 * strip.L);
  const double h = 1e-3;
  const StripRun fine = run_strip(setup, h, 0.6);
  EXPECT_LE(reaction_error(fine, strip, h), 1e-3);
  ASSERT_GT(fine.lift_overhang, 0);
  EXPECT_NEAR(fine.lift_overhang, strip.lift_overhang(), 4 * h);
}

}  // namespace
}  // namespace crease
