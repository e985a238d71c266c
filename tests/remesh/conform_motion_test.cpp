// SPDX-License-Identifier: MIT
// What a pass does to the motion of the sheet: nothing, as far as that can be seen in its momenta.
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "sliding_sheet.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

using support::Rng;
using support::SlidingSheet;
using support::uniform;

constexpr double degree = std::numbers::pi / 180;

// In the truth every point moves at constant speed on its side; every operation must reproduce that.
TEST(Conform, SharesTheVelocityOfASlidingSheetExactly) {
  SlidingSheet sheet({.pattern = GridPattern::Irregular, .place = 0.613});
  sheet.cloth = sheet.conform({}).cloth;
  sheet.bend(-60 * degree);
  ConformOptions options;
  options.look_ahead = 7 * 0.002 / SlidingSheet::speed;
  options.clearance = 0.02;
  for (int step = 0; step < 185; ++step) {  // until the chain comes near the border
    sheet.slide(0.002);
    sheet.cloth = sheet.conform(options).cloth;
    for (int v = 0; v < sheet.cloth.mesh.n_vertices(); ++v) {
      if (sheet.cloth.is_eol(v)) {
        EXPECT_LE((sheet.cloth.V[v] + SlidingSheet::speed * sheet.across()).norm(), 1e-12);
        EXPECT_LE(sheet.cloth.v[v].norm(), 1e-12);
      } else {
        EXPECT_LE((sheet.cloth.v[v] - sheet.velocity(sheet.s(sheet.cloth.mesh.X[v]) >= 0)).norm(), 1e-12);
      }
    }
  }
}

/// Both momenta, the angular one about the centre of mass, and no more kinetic energy.
void expect_kept(const Cloth& before, const Cloth& after) {
  const Motion was = motion(before), is = motion(after);
  const double scale = std::sqrt(2 * was.kinetic * was.area);
  EXPECT_LE((is.linear - was.linear).norm(), 1e-13 * scale);
  EXPECT_LE((is.angular - was.angular).norm(), 1e-13 * scale);
  EXPECT_LE(is.kinetic, was.kinetic * (1 + 1e-13));
}

// Crumpled cloth slips past its chain at metres a second: an operation beside the chain gives F Xdot another F. Those
// around could not always pay for it: in the scene `throw` the sheet once gained .25 % of its energy, and lost spin
// where only those farther off than three rings could.
TEST(Conform, KeepsMomentaBesideAChainThatSlipsThroughCrumpledCloth) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    for (const double speed : {0.0, 1.0}) {
      SCOPED_TRACE(std::to_string(seed) + ", " + std::to_string(speed));
      Rng rng(seed);
      SlidingSheet sheet({.pattern = GridPattern::Irregular, .place = 0.5});
      sheet.cloth = sheet.conform({}).cloth;
      for (int v = 0; v < sheet.cloth.mesh.n_vertices(); ++v) {
        if (sheet.cloth.is_eol(v)) {
          sheet.cloth.V[v] = {uniform(rng, -5, 5), uniform(rng, -1, 1)};
          continue;
        }
        for (double& x : sheet.cloth.mesh.x[v]) x += uniform(rng, -0.02, 0.02);
        for (double& v_i : sheet.cloth.v[v]) v_i = speed * uniform(rng, -1, 1);
      }
      ConformOptions options;
      options.merge = 0.06;
      const RemeshResult result = sheet.conform(options);
      ASSERT_GT(result.report.collapses, 5);
      expect_kept(sheet.cloth, result.cloth);
    }
  }
}

// Where crumpled faces stand against each other their mean F is nearly singular: the Xdot that takes up the velocity of
// a new EOL vertex by it is far faster than the cloth, and the faces' own F Xdot are. In the scene `throw` one at 58
// m/s gave the sheet 4 % more energy than it had.
TEST(Conform, KeepsMomentaWhereAChainBeginsInCrumpledCloth) {
  int n_eol = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    SlidingSheet sheet({.pattern = GridPattern::Irregular, .place = 0.5});
    for (int v = 0; v < sheet.cloth.mesh.n_vertices(); ++v) {
      sheet.cloth.mesh.x[v] += Vec3(uniform(rng, -0.05, 0.05), uniform(rng, -0.05, 0.05), 0);
      sheet.cloth.v[v] = Vec3(1, uniform(rng, -0.05, 0.05), 0);
    }
    const RemeshResult result = sheet.conform({});
    n_eol += result.cloth.n_eol();
    expect_kept(sheet.cloth, result.cloth);
  }
  EXPECT_GT(n_eol, 50);
}

}  // namespace
}  // namespace crease
