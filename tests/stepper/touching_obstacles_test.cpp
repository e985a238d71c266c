// SPDX-License-Identifier: MIT
//
// Obstacles that touch or overlap: edges of two of them in one line, a step between two tops.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "crease/stepper/run.hpp"
#include "crease/stepper/scene_io.hpp"
#include "support/runs.hpp"
#include "support/scratch.hpp"

namespace crease {
namespace {

/// A sheet of 1 x 1 m that hangs over two boxes on all sides and is drawn along x by one border from .3 s on.
/// @param height  of the sheet at the start: above the higher top
std::string drawn_over(const std::string& obstacles, double height) {
  return R"({"format": 1, "name": "drawn", "duration": 0.7, "time_step": 0.005, "gravity": [0, 0, -9.8],
    "cloths": [{"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [8, 8]}},
      "placement": {"origin": [0, 0, )" +
         std::to_string(height) + R"(]},
      "material": {"density": 0.05, "youngs": 500, "poisson": 0.01, "bending": 1e-5, "damping": 0.005},
      "remeshing": {"method": "conformal", "size": [0.06, 0.2]},
      "pins": [{"where": {"edge": "u1"}, "axes": "xyz", "ramp": 0.1,
        "motion": [{"time": 0, "velocity": [0, 0, 0]}, {"time": 0.3, "velocity": [0.3, 0, 0]}]}]}],
    "obstacles": [)" +
         obstacles + R"(], "contact": {"threshold": 0.001}})";
}

struct Outcome {
  double deepest = 0;  // [m]
  double most_eol = 0;
};

Outcome run(const std::string& label, const std::string& text) {
  const std::filesystem::path base = testing::scratch_path("touching_" + label);
  const std::filesystem::path file = base.string() + ".json";
  std::ofstream(file) << text;
  RunOptions options;
  options.directory = base;
  std::filesystem::remove_all(base);
  const RunResult result = run_scene(load_scene(file), options);
  EXPECT_EQ(result.status, RunStatus::Done) << result.message;
  const auto steps = testing::read_steps(base);
  Outcome outcome;
  for (const double depth : steps.at("max_penetration")) outcome.deepest = std::max(outcome.deepest, depth);
  for (const double n : steps.at("eol_vertices")) outcome.most_eol = std::max(outcome.most_eol, n);
  std::filesystem::remove_all(base);
  std::filesystem::remove(file);
  return outcome;
}

// Tops flush, sides flush, and so two pairs of edges in one line and two edges in the same place; then the boxes
// overlap, and edges in one line lie upon each other too. A chain for each of two edges in one place has no room beside
// the other: the run ended at .23 and .28 s, cut down to steps of 5 us. 0.1 % of the sheet's length is allowed.
TEST(TouchingObstacles, ASheetIsDrawnOverTwoBoxesInARow) {
  for (const std::string length : {"0.35", "0.4"}) {
    SCOPED_TRACE(length);
    const Outcome outcome = run("row", drawn_over(R"({"name": "a", "box": {"size": [)" + length +
                                                      R"(, 0.6, 0.35]}, "position": [0.33, 0.5, -0.175]},
      {"name": "b", "box": {"size": [)" + length + R"(, 0.6, 0.35]}, "position": [0.68, 0.5, -0.175]})",
                                                  0.0005));
    EXPECT_LT(outcome.deepest, 1e-3);
    EXPECT_GT(outcome.most_eol, 20);
  }
}

TEST(TouchingObstacles, ASheetIsDrawnOverAStepOfTwoBoxes) {
  const Outcome outcome = run("step", drawn_over(R"({"name": "low", "box": {"size": [0.6, 0.6, 0.3]},
      "position": [0.45, 0.5, -0.15]}, {"name": "high", "box": {"size": [0.3, 0.6, 0.4]}, "position": [0.65, 0.5, -0.15]})",
                                                 0.0505));
  EXPECT_LT(outcome.deepest, 1e-3);
  EXPECT_GT(outcome.most_eol, 10);
}

}  // namespace
}  // namespace crease
