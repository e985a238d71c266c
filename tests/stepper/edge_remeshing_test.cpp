// SPDX-License-Identifier: MIT
//
// What remeshing does to the shipped scene `edge`, judged step by step: the mesh given to the remesher beside the one
// that it returns.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <span>

#include "crease/stepper/scene_io.hpp"
#include "crease/stepper/step.hpp"
#include "support/surface_change.hpp"

namespace crease {
namespace {

constexpr double settled = 0.6;  ///< the fold has formed and the overhang swings no more [s]
constexpr double passage = 3.2;  ///< the border comes to the edge at 3.3 s

TEST(EdgeRemeshing, MovesNoPointOfTheSurfaceByAFifthOfAMillimetre) {
  const LoadedScene loaded =
      load_scene(std::filesystem::path(CREASE_SCENES) / "edge.json",
                 {{"cloths.0.shape.grid.cells", "[11,11]"}, {"cloths.0.remeshing.size", "[0.05,0.12]"}});
  const Scene& scene = loaded.scene;
  const ClothSpec& spec = scene.cloths[0];
  Stages stages = make_stages(scene, spec);
  double jump = 0;
  int changes = 0;
  stages.remesh = [&, remesh = stages.remesh](const Cloth& cloth, std::span<const Contact> contacts,
                                              std::span<const PosedObstacle> obstacles, double h) {
    RemeshResult result = remesh(cloth, contacts, obstacles, h);
    if (result.report.changed) {
      ++changes;
      jump = std::max(jump, testing::surface_change(cloth.mesh, result.cloth.mesh).distance);
    }
    return result;
  };
  SheetStepper stepper({.material = spec.material,
                        .dynamics = {scene.gravity, scene.velocity_terms},
                        .threshold = scene.threshold,
                        .linger = linger_steps * scene.time_step,
                        .pins = spec.pins},
                       stages);
  Cloth cloth = loaded.cloths[0];
  int fewest = 1 << 30, most = 0;
  for (int n = 0; n * scene.time_step < passage; ++n) {
    StepResult result = stepper.step(cloth, scene.obstacles, n * scene.time_step, scene.time_step);
    ASSERT_EQ(result.report.status, StepStatus::Done) << result.report.message;
    cloth = std::move(result.cloth);
    if (n * scene.time_step < settled) continue;
    fewest = std::min(fewest, cloth.mesh.n_faces());
    most = std::max(most, cloth.mesh.n_faces());
  }
  EXPECT_GT(changes, 200);  // the fold passes over .26 m of cloth, through six rows of vertices
  // What one pass may do is 1.5e-4; slides of neighbours may add a little.
  EXPECT_LT(jump, 2e-4);
  EXPECT_LE(most - fewest, 0.1 * (most + fewest)) << "within 10 % of the middle";
}

}  // namespace
}  // namespace crease
