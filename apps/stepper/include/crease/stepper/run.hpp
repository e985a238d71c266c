// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "crease/stepper/scene_io.hpp"
#include "crease/stepper/step.hpp"

namespace crease {

struct RunOptions {
  std::filesystem::path directory;
  std::optional<double> until;       ///< stop early [s]
  bool force = false;                ///< write into a directory that is not empty
  bool resume = false;               ///< continue from the last checkpoint
  std::string command_line;          ///< recorded in summary.json
};

struct RunProgress {
  double time, duration, wall;       ///< [s]
  int step, faces, eol_vertices, contacts, retries;
};

enum class RunStatus { Done = 0, SimulationFailed = 1, FileTrouble = 3, Interrupted = 130 };

struct RunResult {
  RunStatus status = RunStatus::Done;
  std::string message;               ///< step, time, stage and why, when not Done
};

/// Runs a scene and writes everything of the contract's section 3. `progress` is called after each step and may return
/// false to interrupt (what is on disk is then complete).
RunResult run_scene(const LoadedScene& loaded, const RunOptions& options,
                    const std::function<bool(const RunProgress&)>& progress = {});

}  // namespace crease
