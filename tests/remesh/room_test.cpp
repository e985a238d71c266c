// SPDX-License-Identifier: MIT
//
// What adapt() does to the surface, and how it keeps the way of a chain free without being seen.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "crease/geometry/grid.hpp"
#include "crease/remesh/remesh.hpp"
#include "remesh/sliding_sheet.hpp"
#include "support/surface_change.hpp"

namespace crease {
namespace {

using support::SlidingSheet;
using testing::surface_change;

constexpr double degree = std::numbers::pi / 180;
// Of the threshold: what a pass may move the surface by.
constexpr double shift_share = 0.15;

TEST(Adapt, MovesTheSurfaceByAShareOfTheThreshold) {
  for (const double threshold : {1e-4, 1e-3}) {
    for (const GridPattern pattern : {GridPattern::Cross, GridPattern::Right, GridPattern::Irregular}) {
      SCOPED_TRACE("threshold " + std::to_string(threshold) + ", pattern " + std::to_string(static_cast<int>(pattern)));
      GridOptions grid;
      grid.cells = {25, 25};
      grid.pattern = pattern;
      Cloth sheet = make_cloth(make_grid(grid));
      for (int v = 0; v < sheet.mesh.n_vertices(); ++v) {
        const Vec2& X = sheet.mesh.X[v];
        sheet.mesh.x[v].z() = 0.004 * std::sin(7 * X.x() + 2 * X.y()) * std::cos(6 * X.y());
      }
      AdaptOptions options;
      options.size = {0.05, 0.3};
      options.threshold = threshold;
      const RemeshResult result = adapt(sheet, options);
      EXPECT_GT(result.report.collapses + result.report.flips, 0);
      EXPECT_LE(surface_change(sheet.mesh, result.cloth.mesh).distance, shift_share * threshold * (1 + 1e-9));
    }
  }
}

AdaptOptions sizes_of_sliding_sheet() {
  AdaptOptions options;
  options.size = {0.03, 0.08};
  options.velocity = 1e9;  // the fold's jump in velocity is the chain's, but chains at an end leave some of it
  return options;
}

// The hanging part is a cylinder, so that every row of vertices that the chain would run over is a kink.
TEST(Adapt, SlidesVerticesAheadOfAChainUnseen) {
  for (const double degrees : {0.0, 30.0}) {
    SCOPED_TRACE("angle " + std::to_string(degrees));
    SlidingSheet sheet({.pattern = GridPattern::Cross, .angle = degrees * degree, .place = 0.5});
    const double stride = 0.0005;
    ConformOptions options;
    options.look_ahead = 7 * stride / SlidingSheet::speed;
    options.clearance = 0.02;
    sheet.cloth = sheet.conform(options).cloth;
    sheet.bend(-60 * degree, 2.0);
    double jump = 0;
    for (int step = 0; step < 300; ++step) {
      ASSERT_GE(0.3 * sheet.room(), stride) << "the step would be cut at step " << step;
      sheet.slide(stride);
      const RemeshResult conformed = sheet.conform(options);
      const RemeshResult adapted = adapt(conformed.cloth, sizes_of_sliding_sheet());
      jump = std::max(jump, surface_change(sheet.cloth.mesh, adapted.cloth.mesh).distance);
      ASSERT_LE((adapted.report.after.linear - adapted.report.before.linear).norm(),
                1e-12 * adapted.report.before.linear.norm());
      sheet.cloth = adapted.cloth;
      ASSERT_EQ(sheet.trouble(), std::nullopt) << "step " << step;
    }
    EXPECT_LE(jump, 2e-4);
  }
}

TEST(Adapt, ComesToRestBesideAChain) {
  SlidingSheet sheet({.pattern = GridPattern::Irregular, .angle = 20 * degree, .place = 0.4});
  sheet.cloth = sheet.conform({}).cloth;
  sheet.bend(-60 * degree, 2.0);
  RemeshResult result = adapt(sheet.cloth, sizes_of_sliding_sheet());
  int passes = 1;
  for (; result.report.changed && passes < 100; ++passes) result = adapt(result.cloth, sizes_of_sliding_sheet());
  EXPECT_LT(passes, 100);
  EXPECT_EQ(validate(result.cloth), std::nullopt);
}

}  // namespace
}  // namespace crease
