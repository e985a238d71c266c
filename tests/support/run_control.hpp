// SPDX-License-Identifier: MIT
#pragma once

// Runs that are stopped, or made to fail, where a test wants it.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "support/runs.hpp"

namespace crease::testing {

using Names = std::vector<std::string>;

inline nlohmann::json summary_of(const fs::path& directory) {
  return nlohmann::json::parse(bytes_of(directory / "summary.json"));
}

/// Interrupts after the given step of this call.
inline std::function<bool(const RunProgress&)> stop_after(int step) {
  return [step](const RunProgress& progress) { return progress.step < step; };
}

/// Stages whose solver fails where `fails(call)` says so, calls counted from 1 over all steps and sheets.
inline auto failing_solver(std::function<bool(int)> fails) {
  auto calls = std::make_shared<int>(0);
  return [calls, fails](const Scene& scene, const ClothSpec& spec) {
    Stages stages = make_stages(scene, spec);
    stages.solve = [calls, fails, shipped = stages.solve](const QpProblem& problem, std::span<const char> guess) {
      QpResult result = shipped(problem, guess);
      if (fails(++*calls)) result.status = QpStatus::IterationLimit;
      return result;
    };
    return stages;
  };
}

}  // namespace crease::testing
