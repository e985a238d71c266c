// SPDX-License-Identifier: MIT
//
// Triangle meshes as obstacles of whole scenes, judged from outside: on the frames they wrote.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "crease/collision/detect.hpp"
#include "crease/geometry/obstacle.hpp"
#include "crease/stepper/scene_io.hpp"
#include "support/scene_run.hpp"
#include "support/scene_text.hpp"

namespace crease {
namespace {

using testing::Frame;

std::string obj_text(const ObstacleShape& shape) {
  std::string text;
  for (const Vec3& p : shape.vertices)
    text += "v " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
  for (const auto& [a, b, c] : shape.triangles)
    text += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " + std::to_string(c + 1) + "\n";
  return text;
}

/// Farthest that a vertex of one run is from the same in the other; infinite if they have other vertices.
double farthest_apart(const Frame& a, const Frame& b) {
  if (a.x.size() != b.x.size() || a.faces != b.faces) return INFINITY;
  double farthest = 0;
  for (std::size_t i = 0; i < a.x.size(); ++i) farthest = std::max(farthest, (a.x[i] - b.x[i]).norm());
  return farthest;
}

// The table of scenes/edge.json as twelve triangles: its features have other numbers, so that rows and contacts come in
// another order and sums round otherwise, by 1e-16 of a metre. A second of falling, swinging and sliding magnifies that
// by no more than 1e4.
TEST(MeshScene, MovesOverAMeshedTableAsOverTheBox) {
  const TestFolder folder;
  const auto file = folder.write("table.obj", obj_text(make_box({1.2, 1.5, 1.0})));
  const std::vector<std::pair<std::string, std::string>> coarse{{"cloths.0.shape.grid.cells", "[11,11]"},
                                                                {"cloths.0.remeshing.size", "[0.05,0.12]"}};
  auto meshed = coarse;
  meshed.emplace_back("obstacles.0", R"({"name": "table", "mesh": {"file": ")" + file.string() +
                                         R"("}, "position": [0.9175, 0.4425, -0.549]})");
  const auto box = testing::run_shipped("edge", coarse, "as_box", 1);
  const auto mesh = testing::run_shipped("edge", meshed, "as_mesh", 1);
  ASSERT_EQ(box.size(), mesh.size());
  ASSERT_GE(box.size(), 60u);
  for (std::size_t k = 0; k < box.size(); ++k) {
    EXPECT_LE(farthest_apart(box[k], mesh[k]), 1e-12) << "at " << box[k].time << " s";
    EXPECT_EQ(box[k].eol, mesh[k].eol) << "at " << box[k].time << " s";
  }
  EXPECT_GE(box.back().eol.size(), 10u);
}

// scenes/prism.obj: five ridges along y, their tops at these x and z = 0.
TEST(MeshScene, BendsAtEveryRidgeOfThePrism) {
  const auto frames = testing::run_shipped(
      "prism", {{"cloths.0.shape.grid.cells", "[12,10]"}, {"cloths.0.remeshing.size", "[0.05,0.12]"}}, "coarse", 0.6);
  ASSERT_GE(frames.size(), 35u);
  const LoadedScene scene = load_scene(std::filesystem::path(CREASE_SCENES) / "prism.json", {});
  const PosedObstacle prism{&scene.scene.obstacles[0].shape, scene.scene.obstacles[0].start};
  const std::array<double, 5> ridges{0.2, 0.32, 0.45, 0.6, 0.9};
  for (const Frame& frame : frames) {
    // 0.1 % of the sheet's 1.2 m. Behind the first ridge the wall bends by 10 degrees, too little for a feature.
    EXPECT_LE(max_penetration(make_cloth(Mesh(frame.X, frame.x, frame.faces)), {&prism, 1}, 8), 1.2e-3)
        << "at " << frame.time << " s";
    if (frame.time < 0.4) continue;
    for (const double x : ridges)
      EXPECT_GE(std::count_if(frame.eol.begin(), frame.eol.end(),
                              [&](int v) { return std::hypot(frame.x[v].x() - x, frame.x[v].z()) < 5e-4; }),
                6)
          << "at " << frame.time << " s, ridge at x = " << x;
  }
}

}  // namespace
}  // namespace crease
