// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "crease/stepper/run.hpp"

namespace crease::cli {

/// Shows on standard error how far a run is: a bar on a terminal, a line every few seconds elsewhere.
class Progress {
 public:
  Progress(std::string name, bool quiet);
  void update(const RunProgress& progress);
  /// Ends the bar's line, so that what follows starts on its own.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  std::string bar(const RunProgress& progress, double remaining) const;

  std::string name_;
  bool quiet_, terminal_;
  bool line_open_ = false;
  std::optional<double> first_time_;  // simulated time at the first update: a resumed run does not start at 0
  Clock::time_point begin_, shown_;
};

/// "1:02:03", "2:03" or "0:03".
std::string clock_text(double seconds);

}  // namespace crease::cli
