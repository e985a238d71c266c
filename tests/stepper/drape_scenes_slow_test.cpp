// SPDX-License-Identifier: MIT
//
// The shipped scenes `drape_corner` and, coarser, `tablecloth`, run whole and judged on the frames they wrote.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/scene_run.hpp"
#include "support/scratch.hpp"

namespace crease {
namespace {

using testing::Frame;

TEST(DrapeCornerScene, ComesToRestOverCornerAndEdges) {
  const auto frames = testing::run_shipped("drape_corner", {}, "shipped");
  ASSERT_GE(frames.size(), 120u);
  double deepest = 0;
  for (const Frame& frame : frames)
    deepest = std::max(deepest, testing::box_penetration(frame, {-1, -1, -1}, {0, 0, 0}));
  EXPECT_LE(deepest, 1e-3) << "0.1 % of the sheet's length";
  const Frame &last = frames.back(), &before = frames[frames.size() - 2];
  const auto count = [&](auto&& test) { return std::count_if(last.eol.begin(), last.eol.end(), test); };
  EXPECT_EQ(count([&](int v) { return last.x[v].norm() < 5e-4; }), 1) << "on the corner";
  EXPECT_GE(count([&](int v) { return std::hypot(last.x[v].x(), last.x[v].z()) < 5e-4; }), 6) << "on one edge";
  EXPECT_GE(count([&](int v) { return std::hypot(last.x[v].y(), last.x[v].z()) < 5e-4; }), 6) << "on the other";
  double moved2 = 0;
  for (std::size_t v = 0; v < last.x.size(); ++v)
    moved2 += (last.x[v] - testing::world_of(before, last.X[v])).squaredNorm();
  const double speed = std::sqrt(moved2 / static_cast<double>(last.x.size())) / (last.time - before.time);
  EXPECT_LE(speed, 1e-2) << "root mean square of all vertices [m/s]";
}

TEST(TableclothScene, IsPulledOffTheTable) {
  const auto frames = testing::run_shipped(
      "tablecloth", {{"cloths.0.shape.grid.cells", "[10,10]"}, {"cloths.0.remeshing.size", "[0.08,0.2]"}}, "coarse");
  ASSERT_GE(frames.size(), 150u);
  double deepest = 0;
  std::size_t most = 0;
  for (const Frame& frame : frames) {
    deepest = std::max(deepest, testing::box_penetration(frame, {-0.55, -0.55, -0.7}, {0.55, 0.55, 0}));
    most = std::max(most, frame.eol.size());
  }
  EXPECT_LE(deepest, 1.5e-3) << "0.1 % of the cloth's length";
  EXPECT_GE(most, 40u) << "four edges and four corners";
  for (const Vec3& x : frames.back().x) EXPECT_GT(x.x(), 0.55);
}

// At every step and part of a step, not in the frames alone. Clearing a fast chain's way took what kept the cloth out
// above the gaps of other chains, and put it 2.9 mm in.
TEST(TableclothScene, IsNeverInTheTable) {
  const LoadedScene scene = load_scene(std::filesystem::path(CREASE_SCENES) / "tablecloth.json", {});
  RunOptions options;
  options.directory = testing::scratch_path("tablecloth_shipped");
  options.force = true;
  const RunResult result = run_scene(scene, options);
  std::filesystem::remove_all(options.directory);
  ASSERT_EQ(result.status, RunStatus::Done) << result.message;
  EXPECT_LE(result.reached.worst_penetration, 1.5e-3) << "0.1 % of the cloth's length";
}

}  // namespace
}  // namespace crease
