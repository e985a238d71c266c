// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "crease/stepper/scene.hpp"

namespace crease {

/// Every time a run visits. A function of the scene alone, so that a resumed run and an undisturbed one agree.
struct Schedule {
  /// Throws std::invalid_argument if the scene asks for more steps than can be counted.
  explicit Schedule(const Scene& scene);

  double time_step, duration;
  int n_steps;
  std::vector<double> frame_times;  ///< of all frames of the whole run

  double end_of(int step) const;     ///< step 1 is the first; 0 gives the start
  double size_of(int step) const;    ///< time_step, less for a last step cut short
  int frames_until(int step) const;  ///< number of frames that show the states after steps 0..step

 private:
  std::vector<int> frame_steps_;  // ascending
};

}  // namespace crease
