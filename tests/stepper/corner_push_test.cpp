// SPDX-License-Identifier: MIT
//
// A box on its tip is thrown up through the middle, the border and the corner of a free sheet.
#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "crease/stepper/run.hpp"
#include "crease/stepper/scene_io.hpp"
#include "support/runs.hpp"
#include "support/scratch.hpp"

namespace crease {
namespace {

std::string digits(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};  // all of them: 1e-12 must not be lost
}

/// The tip of the box begins 2 mm below the sheet at (x, y) and goes up at 1 m/s for .3 s.
/// @return the deepest penetration over all steps [m]
double push(double x, double y) {
  const std::filesystem::path base = testing::scratch_path("corner_push");
  const std::filesystem::path file = base.string() + ".json";
  std::ofstream(file) << R"({"format": 1, "name": "push", "duration": 0.35, "time_step": 0.005, "gravity": [0, 0, -9.8],
    "cloths": [{"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [8, 8], "pattern": "cross"}},
      "material": {"density": 0.05, "youngs": 500, "poisson": 0.3, "bending": 1e-5, "damping": 0.005},
      "remeshing": {"method": "conformal", "size": [0.06, 0.15]}}],
    "obstacles": [{"name": "box", "box": {"size": [0.3, 0.3, 0.3]}, "position": [)"
                      << digits(x) << "," << digits(y) << R"(, -0.262],
      "rotation": {"axis": [1, -1, 0], "degrees": 54.7356103},
      "motion": [{"time": 0, "velocity": [0, 0, 1]}, {"time": 0.3}]}],
    "contact": {"threshold": 0.001}, "output": {"formats": ["obj"]}})";
  RunOptions options;
  options.directory = base;
  std::filesystem::remove_all(base);
  const RunResult result = run_scene(load_scene(file), options);
  EXPECT_EQ(result.status, RunStatus::Done) << result.message;
  const std::vector<double> depths = testing::read_steps(base).at("max_penetration");
  std::filesystem::remove_all(base);
  std::filesystem::remove(file);
  return *std::max_element(depths.begin(), depths.end());
}

// 0.1 % of the sheet's length is allowed. 1e-12 and 1e-6 m off, the corner meets a vertex, an edge or a face of the
// mesh.
TEST(CornerPush, GoesThroughMiddleBorderAndCornerAlike) {
  const std::vector<Vec2> places{{0.5, 0.5}, {0.5, 0.0}, {0.5, 0.02}, {0.0, 0.0}, {0.015, 0.015}};
  for (const Vec2& place : places) {
    for (const double off : {0.0, 1e-12, -1e-12, 1e-6, -1e-6}) {
      SCOPED_TRACE(digits(place.x()) + ", " + digits(place.y()) + " and " + digits(off));
      EXPECT_LT(push(place.x() + off, place.y()), 1e-3);
    }
  }
}

}  // namespace
}  // namespace crease
