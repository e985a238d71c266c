// SPDX-License-Identifier: MIT
#include "run_schedule.hpp"

#include <algorithm>
#include <cmath>

#include "crease/base/require.hpp"

namespace crease {
namespace {

/// Share of a time step by which a time may miss a multiple that it was meant to hit: round-off of products such as
/// 3 * 0.005 is 1e-16 of them, a scene's decimals are good to 1e-6 at worst.
constexpr double slack = 1e-6;

constexpr double most_steps = 1e8;

}  // namespace

Schedule::Schedule(const Scene& scene) : time_step(scene.time_step), duration(scene.duration) {
  require(time_step > 0 && duration >= 0 && duration / time_step <= most_steps && scene.fps > 0,
          "run_scene: expected time_step > 0, fps > 0 and 0 <= duration <= 1e8 time steps");
  n_steps = static_cast<int>(std::ceil(duration / time_step - slack));
  n_steps = std::max(n_steps, 0);
  double last = -1;
  for (int step = 0; step <= n_steps; ++step) {
    const double period = std::floor((end_of(step) + slack * time_step) * scene.fps);
    if (period <= last) continue;
    last = period;
    frame_steps_.push_back(step);
    frame_times.push_back(end_of(step));
  }
}

double Schedule::end_of(int step) const {
  return step >= n_steps ? duration : step * time_step;
}

double Schedule::size_of(int step) const {
  const double left = duration - (step - 1) * time_step;
  return left < (1 - slack) * time_step ? left : time_step;
}

int Schedule::frames_until(int step) const {
  return static_cast<int>(std::upper_bound(frame_steps_.begin(), frame_steps_.end(), step) - frame_steps_.begin());
}

}  // namespace crease
