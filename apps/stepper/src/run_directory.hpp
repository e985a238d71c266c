// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "crease/stepper/run.hpp"

namespace crease {

/// Where a run's files are.
struct RunDirectory {
  std::filesystem::path root;
  std::filesystem::path checkpoint() const { return root / "checkpoint.bin"; }
  std::filesystem::path steps() const { return root / "steps.csv"; }
};

/// Why a run must not start in this directory, or nothing. Changes nothing.
std::optional<std::string> refusal(const RunDirectory& directory, const RunOptions& options);

/// Removes the frames from number `first_frame` on and whatever half-written file a killed run left.
void remove_frames(const RunDirectory& directory, int first_frame);

/// Removes all files of an earlier run, the checkpoint first; foreign files stay.
void remove_run(const RunDirectory& directory);

}  // namespace crease
