// SPDX-License-Identifier: MIT
#pragma once

// A scene with one sheet run through the shipped stages in memory, and how far two runs of it are apart.

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "crease/collision/detect.hpp"
#include "crease/stepper/scene_io.hpp"
#include "crease/stepper/step.hpp"
#include "support/frames.hpp"

namespace crease::testing {

struct SheetRun {
  std::vector<Cloth> states;  ///< at the start, and at the end of every step
  double deepest = 0;         ///< penetration at the ends of steps [m]
  int parts = 0;              ///< that the steps were taken in
};

namespace detail {

/// A step, in halves of halves where it fails. Throws std::runtime_error if no part succeeds.
inline void take_step(SheetStepper& stepper, const Scene& scene, double time, double h, SheetRun& run, Cloth& cloth) {
  StepResult result = stepper.step(cloth, scene.obstacles, time, h);
  if (result.report.status == StepStatus::Done) {
    cloth = std::move(result.cloth);
    ++run.parts;
    return;
  }
  if (h < scene.time_step / 512)
    throw std::runtime_error(std::string(to_string(result.report.status)) + " at " + std::to_string(time) + " s");
  take_step(stepper, scene, time, h / 2, run, cloth);
  take_step(stepper, scene, time + h / 2, h / 2, run, cloth);
}

}  // namespace detail

inline SheetRun run_sheet(const LoadedScene& loaded, double until) {
  const Scene& scene = loaded.scene;
  const ClothSpec& spec = scene.cloths.front();
  SheetSettings settings;
  settings.material = spec.material;
  settings.dynamics = {scene.gravity, scene.velocity_terms};
  settings.threshold = scene.threshold;
  settings.push_out_speed = 0.5 * scene.threshold / scene.time_step;  // as a run of the scene has it
  settings.pins = spec.pins;
  SheetStepper stepper(std::move(settings), make_stages(scene, spec));
  SheetRun run;
  run.states.push_back(loaded.cloths.front());
  for (int n = 0; (n + 0.5) * scene.time_step < until; ++n) {
    Cloth cloth = run.states.back();
    detail::take_step(stepper, scene, n * scene.time_step, scene.time_step, run, cloth);
    std::vector<PosedObstacle> posed;
    for (const Obstacle& obstacle : scene.obstacles)
      posed.push_back({&obstacle.shape, pose_at(obstacle, (n + 1) * scene.time_step)});
    run.deepest = std::max(run.deepest, max_penetration(cloth, posed));
    run.states.push_back(std::move(cloth));
  }
  return run;
}

inline Frame frame_of(const Cloth& cloth) {
  Frame frame;
  frame.x = cloth.mesh.x;
  frame.X = cloth.mesh.X;
  for (int f = 0; f < cloth.mesh.n_faces(); ++f) frame.faces.push_back(cloth.mesh.face(f));
  return frame;
}

/// Largest distance between the places that two states give to the same material point, over a lattice of 21 x 21 on
/// the unit square [m].
/// @param twin   the second state's material point for one of the first's
/// @param moved  what the second state's places have to be moved by
template <class Twin>
double apart(const Cloth& a, const Cloth& b, Twin twin, const Vec3& moved = Vec3::Zero()) {
  const Frame first = frame_of(a), second = frame_of(b);
  double farthest = 0;
  for (int i = 0; i <= 20; ++i)
    for (int j = 0; j <= 20; ++j) {
      const Vec2 X(i / 20.0, j / 20.0);
      farthest = std::max(farthest, (world_of(first, X) - world_of(second, twin(X)) - moved).norm());
    }
  return farthest;
}
inline double apart(const Cloth& a, const Cloth& b) {
  return apart(a, b, [](const Vec2& X) { return X; });
}

}  // namespace crease::testing
