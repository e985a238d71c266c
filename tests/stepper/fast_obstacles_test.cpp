// SPDX-License-Identifier: MIT
//
// Obstacles that go far within a step, and edges and corners that meet a sheet in full motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "crease/stepper/run.hpp"
#include "crease/stepper/scene_io.hpp"
#include "support/frames.hpp"
#include "support/runs.hpp"
#include "support/scratch.hpp"

namespace crease {
namespace {

constexpr double threshold = 1e-3;

struct Ran {
  std::vector<testing::Frame> frames;
  double deepest = 0;  // penetration over all steps [m]
};

Ran run(const std::filesystem::path& file, std::vector<std::pair<std::string, std::string>> changes,
        std::optional<double> until = std::nullopt) {
  changes.emplace_back("output.formats", R"(["obj"])");
  RunOptions options;
  options.directory = testing::scratch_path("fast_" + file.stem().string());
  options.until = until;
  std::filesystem::remove_all(options.directory);
  const RunResult result = run_scene(load_scene(file, changes), options);
  EXPECT_EQ(result.status, RunStatus::Done) << result.message;
  Ran ran{testing::read_frames(options.directory)};
  const auto steps = testing::read_steps(options.directory);
  for (const double depth : steps.at("max_penetration")) ran.deepest = std::max(ran.deepest, depth);
  std::filesystem::remove_all(options.directory);
  return ran;
}

/// Height of the topmost face of the sheet above the vertical through `p`, over p; far below if there is none.
double height_above(const testing::Frame& frame, const Vec3& p) {
  double highest = -1e3;
  for (const auto& f : frame.faces) {
    const Vec3 &a = frame.x[f[0]], u = frame.x[f[1]] - a, v = frame.x[f[2]] - a, r = p - a;
    const double det = u.x() * v.y() - u.y() * v.x();
    const double s = (r.x() * v.y() - r.y() * v.x()) / det, t = (u.x() * r.y() - u.y() * r.x()) / det;
    if (s >= -1e-9 && t >= -1e-9 && s + t <= 1 + 1e-9)
      highest = std::max(highest, a.z() + s * u.z() + t * v.z() - p.z());
  }
  return highest;
}

Ran run_nail(const Vec3& start) {
  const std::filesystem::path file = testing::scratch_path("nail_at_50").replace_extension("json");
  std::ofstream out(file);
  out << R"({"format": 1, "name": "nail", "duration": 0.06, "time_step": 0.005, "gravity": [0, 0, 0],
    "cloths": [{"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [10, 10], "pattern": "cross"}},
      "material": {"density": 0.05, "youngs": 50, "poisson": 0.01, "bending": 1e-5},
      "remeshing": {"method": "conformal", "size": [0.04, 0.1]}}],
    "obstacles": [{"name": "nail", "point": {"normal": [0, 0, 1]}, "position": [)"
      << start.x() << "," << start.y() << "," << start.z() << R"(],
      "motion": [{"time": 0, "velocity": [0, 0, 50]}, {"time": 0.012, "velocity": [0, 0, 0.5]}]}],
    "contact": {"threshold": 0.001}, "output": {"fps": 200}})";
  out.close();
  Ran ran = run(file, {});
  std::filesystem::remove(file);
  return ran;
}

// A quarter of a metre a step: it would have been through before anybody looked.
TEST(FastObstacles, ANailAt50MetresASecondTakesTheSheetAlong) {
  for (const Vec3& start : {Vec3(0.513, 0.537, -0.35), Vec3(0.5, 0.5, -0.3), Vec3(0.275, 0.6, -0.251)}) {
    SCOPED_TRACE(start.transpose());
    const Ran ran = run_nail(start);
    ASSERT_EQ(ran.frames.size(), 13u);
    for (const testing::Frame& frame : ran.frames) {
      const double t = frame.time, way = t < 0.012 ? 50 * t : 0.6 + 0.5 * (t - 0.012);
      EXPECT_GE(height_above(frame, start + Vec3(0, 0, way)), -threshold) << "at " << t << " s";
    }
  }
}

// scenes/throw.json: a box thrown up spinning at 2 m/s under a free sheet. Edges of the sheet that were beside an edge
// of the box at the beginning of a step cut it at the end, up to 3.9 mm deep.
TEST(FastObstacles, AThrownBoxStaysOutOfTheSheet) {
  const Ran ran = run(std::filesystem::path(CREASE_SCENES) / "throw.json", {}, 0.4);
  EXPECT_LT(ran.deepest, threshold);  // .1 % of the sheet's length
}

}  // namespace
}  // namespace crease
