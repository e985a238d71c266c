// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "crease/stepper/scene_io.hpp"
#include "crease/stepper/step.hpp"

namespace crease {

struct RunOptions {
  std::filesystem::path directory;
  std::optional<double> until = {};  ///< stop after the first step that ends at or after it, Done but not finished [s]
  /// Write into a directory that is not empty. An earlier run's files go once this one's first step has succeeded and
  /// its own checkpoint stands in the old one's place.
  bool force = false;
  bool resume = false;            ///< continue from the last checkpoint
  std::string command_line = {};  ///< recorded in summary.json
  /// Makes the stages of each sheet: assign another function to run with a stage of your own.
  /// Empty: make_stages() on that many threads.
  std::function<Stages(const Scene&, const ClothSpec&)> stages = {};
  int threads = 1;  ///< >= 1; any number gives the same bytes
};

struct RunProgress {
  double time, duration;  ///< reached, and asked for: the scene's duration or `until` [s]
  double wall;            ///< spent so far, earlier parts of a resumed run included [s]
  int step, faces, eol_vertices, contacts, retries;
  double worst_penetration;  ///< deepest place of a cloth inside an obstacle at any step's end so far [m]
};

/// The numbers are the program's exit statuses.
enum class RunStatus {
  Done = 0,
  SimulationFailed = 1,  ///< what is on disk is complete up to the last good step
  Refused = 2,           ///< directory in use or not empty, nothing there to resume, another scene's; nothing written
  FileTrouble = 3,
  Interrupted = 130  ///< by `progress`; what is on disk is complete and `resume` continues
};

struct RunResult {
  RunStatus status = RunStatus::Done;
  std::string message;                     ///< step, time, stage and why, when not Done
  RunProgress reached = {};                ///< where the run stands now; zeros if it did not begin
  std::vector<std::string> warnings = {};  ///< what the scene asks for and cannot get; in summary.json too
};

/// Runs a scene and writes everything of the contract's section 3.
///
/// Time. Step k ends at k time_step; the last one is cut to end at `duration`. A step that fails is retried with half
/// the step, down to time_step/1024; the parts grow again as soon as they fit. All sheets take a step, or none does.
///
/// Frames. Frame 0 is the start; after it, a frame is the state at the first step end at or after a multiple of 1/fps,
/// at most one a step; each carries its true time.
///
/// Repeatability. Same binary, scene and directory content give the same bytes, except for what measures wall time: the
/// t_* columns of steps.csv and the times in summary.json. Every 20 steps the state goes to disk and the run goes on
/// from what was written, with steppers that remember nothing, just as a resumed run does: so both write the same
/// bytes.
///
/// @param progress  called after each step; returns false to interrupt
RunResult run_scene(const LoadedScene& loaded, const RunOptions& options,
                    const std::function<bool(const RunProgress&)>& progress = {});

}  // namespace crease
