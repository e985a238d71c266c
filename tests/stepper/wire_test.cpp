// SPDX-License-Identifier: MIT
// A sheet on a wire, step by step: the wire pushes, and does not pull.
#include <cmath>

#include <gtest/gtest.h>

#include "crease/geometry/grid.hpp"
#include "crease/stepper/step.hpp"

namespace crease {
namespace {

constexpr double h = 5e-3, threshold = 1e-3, g = 9.8;

Obstacle wire_along_y(double z, std::vector<MotionKey> motion = {}) {
  Obstacle wire;
  wire.name = "wire";
  wire.shape = make_wire({{0.5, -1, 0}, {0.5, 2, 0}});
  wire.start.position = {0, 0, z};
  wire.motion = std::move(motion);
  return wire;
}

SheetStepper make_stepper() {
  Scene scene;
  scene.threshold = threshold;
  scene.obstacles = {wire_along_y(0)};  // only that there is one matters: it asks for the detector
  ClothSpec spec;
  spec.remeshing = RemeshMethod::Conformal;
  spec.adapt.size = {0.1, 0.2};
  SheetSettings settings;
  settings.dynamics.gravity = {0, 0, -g};
  settings.threshold = threshold;
  return {settings, make_stages(scene, spec)};
}

/// The way from the wire to the sheet, along the sheet's own normal turned by `side`, where it is smallest [m].
double lowest_over_wire(const Cloth& cloth, double wire_z) {
  double lowest = 1;
  const Mesh& mesh = cloth.mesh;
  for (const int e : mesh.edges()) {
    const Vec3 &a = mesh.x[mesh.from(e)], &b = mesh.x[mesh.to(e)];
    if ((a.x() - 0.5) * (b.x() - 0.5) > 0 || a.x() == b.x()) continue;
    const double t = (0.5 - a.x()) / (b.x() - a.x());
    lowest = std::min(lowest, (1 - t) * a.z() + t * b.z() - wire_z);
  }
  return lowest;
}

Cloth sheet_at(double z, bool turned) {
  GridOptions grid{.size = {1, 0.6}, .cells = {8, 5}};
  grid.origin = {0.013, 0, z};
  if (turned) {  // its normal points down
    grid.origin.y() = 0.6;
    grid.v = {0, -1, 0};
  }
  return make_cloth(make_grid(grid));
}

// The sheet falls on the wire and hangs over it on both sides, whichever way its own normal points.
TEST(Wire, CarriesASheetWhicheverWayItFaces) {
  for (const bool turned : {false, true}) {
    SCOPED_TRACE(turned ? "turned" : "upright");
    const std::vector<Obstacle> obstacles{wire_along_y(0)};
    Cloth cloth = sheet_at(2e-3, turned);
    SheetStepper stepper = make_stepper();
    for (int n = 0; n < 30; ++n) {
      StepResult result = stepper.step(cloth, obstacles, n * h, h);
      ASSERT_EQ(result.report.status, StepStatus::Done) << result.report.message << " in step " << n;
      cloth = std::move(result.cloth);
      ASSERT_EQ(validate(cloth), std::nullopt);
    }
    EXPECT_GT(cloth.n_eol(), 3);
    // Held within the hover of half a threshold; the free ends have fallen by far more.
    EXPECT_GT(lowest_over_wire(cloth, 0), -0.1 * threshold);
    EXPECT_LT(lowest_over_wire(cloth, 0), 0.5 * threshold);
    double end = 0;
    for (const Vec3& x : cloth.mesh.x) end = std::min(end, x.z());
    EXPECT_LT(end, -0.02);
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
      if (cloth.is_eol(v)) {
        EXPECT_EQ(cloth.feature[v].side, turned ? -1 : 1);
      }
  }
}

// The wire drops at 3 m/s from under a flat sheet that just came to lie on it. Held both ways, the sheet would be
// dragged along; let go, it falls freely: v = -g t, and no vertex ever moves down faster.
TEST(Wire, LetsGoOfASheetWhenItDropsAway) {
  const double drop = 3;
  const std::vector<Obstacle> obstacles{wire_along_y(0, {{.time = 0.01, .velocity = {0, 0, -drop}}})};
  Cloth cloth = sheet_at(1e-4, false);
  SheetStepper stepper = make_stepper();
  int most_eol = 0;
  for (int n = 0; n < 12; ++n) {
    StepResult result = stepper.step(cloth, obstacles, n * h, h);
    ASSERT_EQ(result.report.status, StepStatus::Done) << result.report.message;
    cloth = std::move(result.cloth);
    most_eol = std::max(most_eol, cloth.n_eol());
    if (n < 3) continue;
    for (const Vec3& v : cloth.v) EXPECT_GT(v.z(), -g * (n + 1) * h - 0.1) << "step " << n;
  }
  EXPECT_GT(most_eol, 3);
  EXPECT_EQ(cloth.n_eol(), 0);
}

}  // namespace
}  // namespace crease
