// SPDX-License-Identifier: MIT
#include <algorithm>

#include "crease/base/require.hpp"
#include "crease/stepper/step.hpp"

namespace crease {
namespace {

/// Integral from 0 to u of the quintic blend s(u) = 6 u^5 - 15 u^4 + 10 u^3 (0 before 0, 1 after 1).
double blend_integral(double u) {
  if (u <= 0) return 0;
  if (u >= 1) return 0.5 + (u - 1);
  return u * u * u * u * (2.5 + u * (u - 3));
}

/// Distance gained between times a and b from a unit change of velocity at time `start`, smoothed over `ramp`.
double gained(double a, double b, double start, double ramp) {
  if (ramp <= 0) return std::max(b - start, 0.0) - std::max(a - start, 0.0);
  return ramp * (blend_integral((b - start) / ramp) - blend_integral((a - start) / ramp));
}

}  // namespace

PinState pin_state(const PinSpec& pin, int index, double time, double h) {
  require(h > 0, "pin_state: expected h > 0");
  PinState state;
  state.index = index;
  state.axes = pin.axes;
  // Half a nanosecond of slack: step times are sums of round numbers and may fall short of the release by round-off.
  state.released = pin.release && time >= *pin.release - 5e-10;
  if (pin.motion.empty()) return state;

  Vec3 displacement = Vec3::Zero(), before = Vec3::Zero();
  for (const MotionKey& key : pin.motion) {
    const bool from_the_start = key.time <= 0;  // what holds at time 0 is no change, so nothing to smooth
    displacement += (key.velocity - before) * (from_the_start ? h : gained(time, time + h, key.time, pin.ramp));
    before = key.velocity;
  }
  state.velocity = displacement / h;
  return state;
}

}  // namespace crease
