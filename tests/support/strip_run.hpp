// SPDX-License-Identifier: MIT
#pragma once

// Runs the strip of strip.hpp through the shipped stages and records what its exact solution speaks of.

#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "crease/stepper/step.hpp"
#include "support/strip.hpp"

namespace crease::testing {

struct Sample {
  double time, overhang, speed, spread;
  Vec3 reaction;  // edge reaction of the step that ends at `time`
  int fold_vertices;
};

struct StripRun {
  std::vector<Sample> samples;
  double lift_overhang = -1;
  int cuts = 0;  // steps that were taken in halves
  Cloth last;
};

/// Elements near a given length, and nothing else that asks for refinement.
inline ClothSpec strip_spec(const Strip& strip, double element) {
  ClothSpec spec;
  spec.material = strip.material();
  spec.remeshing = RemeshMethod::Conformal;
  spec.adapt.size = {0.5 * element, 1.5 * element};
  spec.adapt.velocity = 1e3;
  return spec;
}

struct StripSetup {
  Strip strip;
  std::array<int, 2> cells{20, 4};
  GridPattern pattern = GridPattern::Alternating;
  bool mark_fold = true;
  Mat3 turn = Mat3::Identity();
  Vec3 drift = Vec3::Zero();  // velocity that table and strip share [m/s]
};

/// Forces on the cloth, means over a step [N].
struct Reactions {
  Vec3 edge = Vec3::Zero(), pin = Vec3::Zero();
};

/// One step, in halves of halves where the material step is too long.
inline Reactions advance(SheetStepper& stepper, Cloth& cloth, std::span<const Obstacle> obstacles, double time,
                         double h, int& cuts) {
  StepResult result = stepper.step(cloth, obstacles, time, h);
  if (result.report.status == StepStatus::EulerianStepTooLong && h > 1e-5) {
    ++cuts;
    const Reactions first = advance(stepper, cloth, obstacles, time, h / 2, cuts);
    const Reactions second = advance(stepper, cloth, obstacles, time + h / 2, h / 2, cuts);
    return {(first.edge + second.edge) / 2, (first.pin + second.pin) / 2};
  }
  if (result.report.status != StepStatus::Done)
    throw std::runtime_error(std::string(to_string(result.report.status)) + ": " + result.report.message);
  cloth = std::move(result.cloth);
  return {result.report.edge_reaction, result.report.pin_reaction};
}

/// Steps until the fold has left the edge or `end` is reached.
inline StripRun run_strip(const StripSetup& setup, double h, double end) {
  Scene scene;
  scene.obstacles.push_back(strip_table());
  Cloth cloth = make_strip(setup.strip, setup.cells, setup.pattern, setup.mark_fold);
  rotate(cloth, scene.obstacles[0], setup.turn);
  scene.obstacles[0].motion = {{.time = 0, .velocity = setup.drift}};
  for (Vec3& v : cloth.v) v += setup.drift;
  const ClothSpec spec = strip_spec(setup.strip, setup.strip.L / setup.cells[0]);
  SheetSettings settings;
  settings.material = spec.material;
  settings.dynamics.gravity = setup.turn * Vec3(0, 0, -setup.strip.g);
  settings.threshold = scene.threshold;
  SheetStepper stepper(settings, make_stages(scene, spec));

  StripRun run;
  for (int n = 1; n * h < end + 1e-9; ++n) {
    const Fold before = measure_fold(cloth, setup.strip.L);
    const Vec3 reaction =
        setup.turn.transpose() * advance(stepper, cloth, scene.obstacles, (n - 1) * h, h, run.cuts).edge;
    const Fold fold = measure_fold(cloth, setup.strip.L);
    run.samples.push_back({n * h, fold.overhang, fold.speed, fold.speed_spread, reaction, fold.vertices});
    // The side normal's multipliers are zero: the fold is free to leave.
    if (run.lift_overhang < 0 && n > 2 && before.vertices > 0 && reaction.x() <= 1e-12) {
      run.lift_overhang = before.overhang;
      break;
    }
  }
  run.last = std::move(cloth);
  return run;
}

/// Share of the time to lift-off that is judged: at the very end the fold may already be gone.
inline constexpr double judged_until = 0.995;

/// Largest |overhang - exact(t + h/2)| before lift-off: linearly implicit Euler runs half a step ahead.
inline double shifted_error(const StripRun& run, const Strip& strip, double h) {
  double error = 0;
  for (const Sample& s : run.samples)
    if (s.time <= judged_until * strip.lift_time())
      error = std::max(error, std::abs(s.overhang - strip.overhang(s.time + h / 2)));
  return error;
}

/// Root mean square error of the edge reaction's x-component against W (T - rho v^2), in units of rho g L W, from the
/// fifth step to lift-off.
inline double reaction_error(const StripRun& run, const Strip& strip, double h) {
  double square = 0;
  int n = 0;
  for (const Sample& s : run.samples) {
    if (s.time < 5 * h || s.time > judged_until * strip.lift_time()) continue;
    const double exact = strip.W * (strip.tension(s.time) - strip.rho * strip.speed(s.time) * strip.speed(s.time));
    square += std::pow(s.reaction.x() - exact, 2);
    ++n;
  }
  return std::sqrt(square / n) / (strip.rho * strip.g * strip.L * strip.W);
}

}  // namespace crease::testing
