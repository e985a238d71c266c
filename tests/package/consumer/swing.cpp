// SPDX-License-Identifier: MIT
// A towel held by two corners, and a stage of our own: the shipped solver, counted.
#include <cstdio>

#include "crease/geometry/grid.hpp"
#include "crease/stepper/step.hpp"

int main() {
  crease::Scene scene;
  crease::ClothSpec spec;
  spec.pins = {{.where = {.name = "00"}}, {.where = {.name = "01"}}};
  scene.cloths = {spec};

  crease::Cloth cloth = crease::make_cloth(crease::make_grid({.cells = {4, 4}}));
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
    if (cloth.mesh.X[i] == crease::Vec2(0, 0)) cloth.pins[i] = 1;
    if (cloth.mesh.X[i] == crease::Vec2(0, 1)) cloth.pins[i] = 2;
  }

  int solves = 0;
  crease::Stages stages = crease::make_stages(scene, spec);
  stages.solve = [&solves, shipped = stages.solve](const crease::QpProblem& problem, std::span<const char> guess) {
    ++solves;
    return shipped(problem, guess);
  };
  crease::SheetStepper stepper({.material = spec.material, .dynamics = {}, .pins = spec.pins}, stages);
  for (int k = 0; k < 10; ++k) {
    crease::StepResult result = stepper.step(cloth, {}, 0.01 * k, 0.01);
    if (result.report.status != crease::StepStatus::Done) {
      std::fprintf(stderr, "%s: %s\n", result.report.stage.c_str(), result.report.message.c_str());
      return 1;
    }
    cloth = std::move(result.cloth);
  }
  double fall = 0;
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i)
    if (cloth.mesh.X[i] == crease::Vec2(1, 1)) fall = cloth.mesh.x[i].z();
  std::printf("%d solves, free corner at z = %.4f m\n", solves, fall);
  return solves == 10 && fall < 0 ? 0 : 1;
}
