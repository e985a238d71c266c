// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <span>
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
std::optional<std::string> refusal(const RunDirectory& directory, const RunOptions& options, const LoadedScene& loaded);

/// Keeps every other run out of a directory for as long as it lives; a killed process lets go as well.
class DirectoryLock {
 public:
  explicit DirectoryLock(const RunDirectory& directory);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;
  bool taken_by_another() const { return taken_by_another_; }

 private:
  int descriptor_;
  bool taken_by_another_ = false;
};

/// Which of a run's first `n_frames` frames somebody has taken away, in words; or nothing. No resumed run can make them
/// again.
std::optional<std::string> missing_frames(const RunDirectory& directory, std::span<const FrameFormat> formats,
                                          int n_frames);

/// Removes the frames from number `first_frame` on and whatever half-written file a killed run left.
void remove_frames(const RunDirectory& directory, int first_frame);

/// Removes all files of an earlier run but the checkpoint, in whose place the new run's stands already; foreign files
/// stay.
void remove_earlier_run(const RunDirectory& directory);

}  // namespace crease
