// SPDX-License-Identifier: MIT
#include "crease/dynamics/material.hpp"

#include <cmath>
#include <limits>
#include <sstream>

#include "crease/base/require.hpp"

namespace crease {

namespace {

void require_range(const char* name, double value, bool in_range, const char* expected) {
  if (std::isfinite(value) && in_range) return;
  std::ostringstream message;
  message.precision(std::numeric_limits<double>::max_digits10);
  message << "material." << name << ": expected " << expected << ", got " << value;
  require(false, message.str());
}

}  // namespace

void require_valid(const Material& material) {
  require_range("density", material.density, material.density > 0, "a finite number > 0 [kg/m^2]");
  require_range("youngs", material.youngs, material.youngs > 0, "a finite number > 0 [N/m]");
  require_range("poisson", material.poisson, material.poisson >= 0 && material.poisson <= 0.5, "a number in [0, 0.5]");
  require_range("bending", material.bending, material.bending >= 0, "a finite number >= 0 [J]");
  require_range("damping", material.damping, material.damping >= 0, "a finite number >= 0 [s]");
}

}  // namespace crease
