// SPDX-License-Identifier: MIT
#pragma once

// A shipped scene run whole or in part, and the frames it wrote. The test's target defines CREASE_SCENES.

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "crease/stepper/run.hpp"
#include "crease/stepper/scene_io.hpp"
#include "support/frames.hpp"
#include "support/runs.hpp"
#include "support/scratch.hpp"

namespace crease::testing {

/// @param changes  as of `crease run --set`
/// @param label    tells apart what runs at the same time
inline std::vector<Frame> run_shipped(const std::string& name, std::vector<std::pair<std::string, std::string>> changes,
                                      const std::string& label, std::optional<double> until = std::nullopt) {
  changes.emplace_back("output.formats", R"(["obj"])");
  const LoadedScene scene = load_scene(std::filesystem::path(CREASE_SCENES) / (name + ".json"), changes);
  RunOptions options;
  options.directory = scratch_path(name + "_" + label);
  options.until = until;
  std::filesystem::remove_all(options.directory);
  const RunResult result = run_scene(scene, options);
  EXPECT_EQ(result.status, RunStatus::Done) << result.message;
  auto frames = read_frames(options.directory);
  const auto steps = read_steps(options.directory);
  for (Frame& frame : frames)
    for (std::size_t k = 0; k < steps.at("time").size() && steps.at("time")[k] <= frame.time + 1e-9; ++k)
      frame.released += steps.at("released")[k];
  std::filesystem::remove_all(options.directory);
  return frames;
}

}  // namespace crease::testing
