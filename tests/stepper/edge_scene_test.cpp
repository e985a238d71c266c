// SPDX-License-Identifier: MIT
//
// The shipped scene `edge`, run whole and judged from outside: on the frames it wrote, with its own box and pull.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "crease/stepper/run.hpp"
#include "crease/stepper/scene_io.hpp"
#include "support/frames.hpp"

namespace crease {
namespace {

using testing::Frame;

// The box of scenes/edge.json: size (1.2, 1.5, 1) about (.9175, .4425, -.549).
const Vec3 box_low{0.3175, -0.3075, -1.049}, box_high{1.5175, 1.1925, -0.049};
constexpr double edge_x = 0.3175, edge_z = -0.049;
constexpr double pull_speed = 0.1;
constexpr double settled = 0.6;  ///< the swing of the overhang after the fall has died down [s]

std::vector<Frame> run_edge(const std::vector<std::pair<std::string, std::string>>& changes, const std::string& name) {
  auto overrides = changes;
  overrides.emplace_back("output.formats", R"(["obj"])");
  const LoadedScene scene = load_scene(std::filesystem::path(CREASE_SCENES) / "edge.json", overrides);
  RunOptions options;
  options.directory = std::filesystem::temp_directory_path() / ("crease_" + name);
  std::filesystem::remove_all(options.directory);
  const RunResult result = run_scene(scene, options);
  EXPECT_EQ(result.status, RunStatus::Done) << result.message;
  auto frames = testing::read_frames(options.directory);
  std::filesystem::remove_all(options.directory);
  return frames;
}

/// Material overhang: how much cloth is left of the edge along its middle line.
double overhang(const Frame& frame) {
  double sum = 0;
  for (const int v : frame.eol) sum += frame.X[v].x();
  return frame.eol.empty() ? 0 : sum / static_cast<double>(frame.eol.size());
}

/// Largest x of the cloth's border that hangs over the edge: the border has passed when it reaches the edge.
double border_reach(const Frame& frame) {
  double reach = -1e300;
  for (std::size_t v = 0; v < frame.x.size(); ++v)
    if (frame.X[v].x() < 1e-9) reach = std::max(reach, frame.x[v].x());
  return reach;
}

void judge(const std::vector<Frame>& frames) {
  ASSERT_GE(frames.size(), 240u);
  double farthest = 0, deepest = 0, off_feature = 0, jump = 0;
  int judged = 0;
  double first_time = 0, first_overhang = 0, last_time = 0, last_overhang = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Frame& frame = frames[k];
    deepest = std::max(deepest, testing::box_penetration(frame, box_low, box_high));
    for (const int v : frame.eol)
      off_feature = std::max(off_feature, std::hypot(frame.x[v].x() - edge_x, frame.x[v].z() - edge_z));
    if (frame.time < settled || border_reach(frame) >= edge_x) continue;
    ++judged;
    for (double y = 0.05; y < 0.96; y += 0.05)
      farthest = std::max(farthest, testing::distance_to_surface(frame, {edge_x, y, edge_z}));
    jump = std::max(jump, testing::largest_jump(frames[k - 1], frame));
    const double left = overhang(frame);
    if (left > 0.03 && frame.time > settled) {
      if (first_time == 0) first_time = frame.time, first_overhang = left;
      last_time = frame.time, last_overhang = left;
    }
  }
  EXPECT_GE(judged, 150);
  EXPECT_LE(farthest, 5e-4) << "surface to edge line [m]";
  EXPECT_LE(deepest, 1e-3) << "penetration on the lattice [m]";
  EXPECT_LE(off_feature, 1e-9) << "EOL vertex to edge line [m]";
  EXPECT_LE(jump, 0.2) << "vertex against its neighbours [m/s]";
  const double speed = (first_overhang - last_overhang) / (last_time - first_time);
  EXPECT_NEAR(speed, pull_speed, 0.03 * pull_speed);
}

TEST(EdgeScene, SlidesOverTheEdgeAtFiveHundredFaces) {
  judge(run_edge({{"cloths.0.shape.grid.cells", "[11,11]"}, {"cloths.0.remeshing.size", "[0.05,0.12]"}}, "edge_500"));
}

TEST(EdgeScene, SlidesOverTheEdgeAtFullResolution) {
  judge(run_edge({}, "edge_full"));
}

}  // namespace
}  // namespace crease
