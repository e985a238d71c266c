// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "crease/stepper/step.hpp"
#include "support/strip.hpp"

namespace crease {
namespace {

using testing::Fold;
using testing::Strip;

struct Sample {
  double time, overhang, speed, spread;
  Vec3 reaction;  // edge reaction of the step that ends at `time`
  int fold_vertices, released;
};

struct StripRun {
  std::vector<Sample> samples;
  double lift_overhang = -1, lift_time = -1;
  Cloth last;
};

/// Elements near a given length, and nothing else that asks for refinement.
ClothSpec strip_spec(const Strip& strip, double element) {
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
};

/// Steps until the fold has left the edge or `end` is reached.
StripRun run_strip(const StripSetup& setup, double h, double end) {
  Scene scene;
  scene.obstacles.push_back(testing::strip_table());
  Cloth cloth = testing::make_strip(setup.strip, setup.cells, setup.pattern, setup.mark_fold);
  testing::rotate(cloth, scene.obstacles[0], setup.turn);
  const ClothSpec spec = strip_spec(setup.strip, setup.strip.L / setup.cells[0]);
  SheetSettings settings;
  settings.material = spec.material;
  settings.dynamics.gravity = setup.turn * Vec3(0, 0, -setup.strip.g);
  settings.threshold = scene.threshold;
  SheetStepper stepper(settings, make_stages(scene, spec));

  StripRun run;
  double time = 0;
  for (int n = 1; time < end - 1e-9; ++n) {
    const int before = cloth.n_eol();
    StepResult result = stepper.step(cloth, scene.obstacles, time, h);
    EXPECT_EQ(result.report.status, StepStatus::Done)
        << to_string(result.report.status) << " " << result.report.message;
    if (result.report.status != StepStatus::Done) break;
    const Fold last = testing::measure_fold(cloth, setup.strip.L);
    cloth = std::move(result.cloth);
    time = n * h;
    const Fold fold = testing::measure_fold(cloth, setup.strip.L);
    run.samples.push_back({time, fold.overhang, fold.speed, fold.speed_spread,
                           setup.turn.transpose() * result.report.edge_reaction, fold.vertices,
                           result.report.released});
    if (n > 2 && before > 0 && result.report.released > 0 && fold.vertices < before) {
      run.lift_overhang = last.overhang;
      run.lift_time = time;
      break;
    }
  }
  run.last = std::move(cloth);
  return run;
}

/// Largest |overhang - exact(t + h/2)| up to 0.9 of the time of lift-off: linearly implicit Euler runs half a step
/// ahead.
double shifted_error(const StripRun& run, const Strip& strip, double h) {
  double error = 0;
  for (const Sample& s : run.samples)
    if (s.time <= 0.9 * strip.lift_time())
      error = std::max(error, std::abs(s.overhang - strip.overhang(s.time + h / 2)));
  return error;
}

TEST(Strip, FollowsTheExactSlideOverTheEdge) {
  const Strip strip;
  const double h = 2e-3;
  const StripRun run = run_strip({strip}, h, 0.4);
  // 3e-5 L is what a one-dimensional strand of the same scheme reaches at 2 ms (twice its error); the rest is the
  // strain rho g L/E, times the .043 of the exact extensible solution.
  EXPECT_LE(shifted_error(run, strip, h), 3e-5 + 0.05 * strip.rho * strip.g * strip.L / strip.E);
}

TEST(Strip, ConvergesWithSecondOrderAfterTheHalfStepShift) {
  Strip strip;
  strip.E = 1e6;  // rho g L/E = 1e-6: the strain does not hide the order
  const double e8 = shifted_error(run_strip({strip}, 8e-3, 0.37), strip, 8e-3);
  const double e4 = shifted_error(run_strip({strip}, 4e-3, 0.37), strip, 4e-3);
  const double order = std::log2(e8 / e4);
  EXPECT_GE(order, 1.9) << e8 << " " << e4;
  EXPECT_LE(order, 2.1) << e8 << " " << e4;
}

TEST(Strip, EdgeReactionCarriesTheMomentumFlux) {
  const Strip strip;
  const double h = 1e-3;
  const StripRun run = run_strip({strip}, h, 0.4);
  double square = 0;
  int n = 0;
  for (const Sample& s : run.samples) {
    if (s.time < 5 * h || s.time > 0.9 * strip.lift_time()) continue;
    const double t = s.time + h / 2 - h / 2;  // multiplier of the step: mean over it
    const double exact = strip.W * (strip.tension(t) - strip.rho * strip.speed(t) * strip.speed(t));
    square += std::pow(s.reaction.x() - exact, 2);
    ++n;
  }
  EXPECT_LE(std::sqrt(square / n), 1e-3 * strip.rho * strip.g * strip.L * strip.W);
}

TEST(Strip, LeavesTheEdgeWhenTensionIsTheMomentumFlux) {
  const Strip strip;
  const double h = 1e-3;
  const StripRun run = run_strip({strip}, h, 0.6);
  ASSERT_GT(run.lift_overhang, 0);
  EXPECT_NEAR(run.lift_overhang, strip.lift_overhang(), 4 * h);  // first order in h; 4 h in metres for L = 1 m
}

TEST(Strip, SlidesUniformlyAlongTheEdge) {
  const StripRun run = run_strip({Strip{}}, 2e-3, 0.36);
  for (const Sample& s : run.samples) EXPECT_LE(s.spread, 1e-9) << s.time;
}

TEST(Strip, IsTheSameInATurnedScene) {
  std::mt19937_64 random{7};
  std::normal_distribution<double> normal;
  const Mat3 turn = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                        .normalized()
                        .toRotationMatrix();
  StripSetup turned{Strip{}};
  turned.turn = turn;
  const StripRun a = run_strip({Strip{}}, 2e-3, 0.36), b = run_strip(turned, 2e-3, 0.36);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    EXPECT_NEAR(a.samples[i].overhang, b.samples[i].overhang, 1e-9);
    EXPECT_LE((a.samples[i].reaction - b.samples[i].reaction).norm(), 1e-9);
  }
}

TEST(Strip, FindsTheLineByCollisionAndRemeshing) {
  const Strip strip;
  const double h = 2e-3;
  StripSetup setup{strip};
  setup.mark_fold = false;
  const StripRun run = run_strip(setup, h, 0.4);
  EXPECT_LE(shifted_error(run, strip, h), 1e-3 * strip.L);
}

}  // namespace
}  // namespace crease
