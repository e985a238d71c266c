// SPDX-License-Identifier: MIT
//
// Scenes that ask for more than a mesh of their sizes can follow. They have to end, outside, and with what they had to
// leave undone said.
#include <gtest/gtest.h>

#include <string>

#include "support/runs.hpp"
#include "support/scene_text.hpp"

namespace crease {
namespace {

using namespace testing;

/// A sheet of 1 x 1 m, 1 cm above what is under its middle.
std::string sheet_over(const std::string& obstacle, const std::string& size) {
  return R"({"format": 1, "name": "hard", "duration": 0.5, "time_step": 0.005, "gravity": [0, 0, -9.8],
    "cloths": [{"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [8, 8], "pattern": "cross"}},
      "material": {"density": 0.05, "youngs": 500, "poisson": 0.01, "bending": 1e-5},
      "remeshing": {"method": "conformal", "size": )" +
         size + R"(}}],
    "obstacles": [)" +
         obstacle + R"(], "contact": {"threshold": 0.001}})";
}

/// Gathers along a wire until it is folded many times over, beside a box and a nail.
const char* const crumpled = R"({"format": 1, "name": "crumpled", "duration": 0.45, "time_step": 0.005,
  "gravity": [0, 0, -9.8],
  "cloths": [{"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [11, 11], "pattern": "cross"}},
    "material": {"density": 0.05, "youngs": 50, "poisson": 0.01, "bending": 1e-6},
    "remeshing": {"method": "conformal", "size": [0.03, 0.1]}}],
  "obstacles": [
    {"name": "nail", "point": {"normal": [0, 0, 1]}, "position": [0.821, 0.753, -0.0457]},
    {"name": "box", "box": {"size": [0.303, 0.663, 0.793]}, "position": [-0.0682, 0.2248, -0.4069]},
    {"name": "wire", "wire": {"points": [[1.1722, -0.9305, -0.0464], [-0.0577, 1.8059, -0.0464]]}}],
  "contact": {"threshold": 0.001}})";

void expect_ends_outside(const std::string& text) {
  const TestFolder folder;
  LoadedScene loaded = load_scene(folder.write("hard.json", text));
  loaded.scene.formats.clear();
  const RunResult result = run_scene(loaded, {.directory = folder.path() / "run"});
  EXPECT_EQ(result.status, RunStatus::Done) << result.message;
  EXPECT_LE(result.reached.worst_penetration, 1e-3) << "0.1 % of the cloth's length";
  const auto steps = read_steps(folder.path() / "run");
  bool is_troubled = false;
  for (const char* column : {"held", "caught"})
    for (const double n : steps.at(column)) is_troubled = is_troubled || n > 0;
  EXPECT_TRUE(!is_troubled || !result.warnings.empty());
}

TEST(HardScenes, APlateThinnerThanAnyTriangleIsWrapped) {
  expect_ends_outside(
      sheet_over(R"({"box": {"size": [0.5, 0.5, 0.005]}, "position": [0.5, 0.5, -0.01]})", "[0.05, 0.2]"));
}

TEST(HardScenes, ANeedleWithFourCornersHoldsTheSheet) {
  expect_ends_outside(
      sheet_over(R"({"box": {"size": [0.001, 0.001, 0.5]}, "position": [0.5, 0.5, -0.26]})", "[0.05, 0.2]"));
}

TEST(HardScenes, ASheetMayCrumpleOnAWire) {
  expect_ends_outside(crumpled);
}

}  // namespace
}  // namespace crease
