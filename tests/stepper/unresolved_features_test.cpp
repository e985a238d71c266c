// SPDX-License-Identifier: MIT
//
// Features nearer to each other than any mesh of the sizes asked for can tell apart.
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

#include "support/runs.hpp"
#include "support/scene_text.hpp"
#include "support/shaken.hpp"

namespace crease {
namespace {

/// Nine needles, `apart` from each other, that rise from 1 mm under a free sheet of 1 x 1 m with edges of 5 to 10 cm.
LoadedScene needles(double apart) {
  std::string text = R"({"format": 1, "name": "needles", "duration": 0.2, "time_step": 0.005, "gravity": [0, 0, -9.8],
    "cloths": [{"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": [10, 10]}},
      "material": {"density": 0.05, "youngs": 500, "poisson": 0.3, "bending": 1e-5, "damping": 0.005},
      "remeshing": {"method": "conformal", "size": [0.05, 0.1]}}], "obstacles": [)";
  for (int k = 0; k < 9; ++k)
    text += std::string(k > 0 ? "," : "") + R"({"point": {"normal": [0, 0, 1]}, "position": [)" +
            std::to_string(0.51 + apart * (k % 3)) + "," + std::to_string(0.47 + apart * (k / 3)) +
            R"(, -0.001], "motion": [{"time": 0, "velocity": [0, 0, 0.5]}]})";
  const TestFolder folder;
  return load_scene(folder.write("needles.json", text + "]}"));
}

// The sheet has no room for more than one vertex among them: that one carries it, and it comes down over none of the
// others by more than the promised .1 % of its length.
TEST(UnresolvedFeatures, AreToldAndDoNoHarm) {
  const TestFolder folder;
  LoadedScene loaded = needles(1e-4);
  loaded.scene.formats.clear();
  const auto piercing = std::make_shared<testing::Piercing>(1e-3);
  RunOptions options{.directory = folder.path()};
  options.stages = testing::watched_stages(piercing);
  const RunResult result = run_scene(loaded, options);
  EXPECT_EQ(result.status, RunStatus::Done) << result.message;
  EXPECT_EQ(piercing->pierced(), 0);
  ASSERT_EQ(result.warnings.size(), 1u);
  // Merged are vertices within 1 % of the cloth's length; all 36 pairs of nine needles are.
  for (const char* words : {"'sheet'", "'obstacle0'", "0.1 mm", "10 mm", "36 such pairs"})
    EXPECT_NE(result.warnings[0].find(words), std::string::npos) << result.warnings[0] << "\nlacks " << words;
  EXPECT_NE(testing::bytes_of(folder.path() / "summary.json").find("cannot resolve"), std::string::npos);
}

// Needles 2 cm apart, and boxes in a row whose corners coincide.
TEST(UnresolvedFeatures, AreNotThoseThatTheMeshTellsApartOrThatShareAPlace) {
  LoadedScene loaded = needles(0.02);
  loaded.scene.obstacles.push_back({.name = "a", .shape = make_box({1, 1, 1}), .start = {}, .motion = {}});
  loaded.scene.obstacles.back().start.position = {0, 0, -2};
  loaded.scene.obstacles.push_back(loaded.scene.obstacles.back());
  loaded.scene.obstacles.back().start.position.x() = 1;
  const TestFolder folder;
  const RunResult result = run_scene(loaded, {.directory = folder.path(), .until = 0.005});
  EXPECT_EQ(result.status, RunStatus::Done) << result.message;
  EXPECT_TRUE(result.warnings.empty()) << result.warnings[0];
}

}  // namespace
}  // namespace crease
