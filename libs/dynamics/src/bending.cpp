// SPDX-License-Identifier: MIT
#include "crease/dynamics/bending.hpp"

#include "crease/base/require.hpp"
#include "element.hpp"

namespace crease {

namespace {

// Times 3 s = 1: the energy 3 B/(A_0 + A_1) of the literature bends like a plate of 3 B on an equilateral mesh.
constexpr double plate_scale = 1.0 / 3.0;  // s [1]

}  // namespace

double scaled(double bending) {
  return 3 * plate_scale * bending;
}

BendingElement bending_element(const std::array<Vec2, 4>& X, double bending) {
  double corner[4][2];
  for (int i = 0; i < 4; ++i) corner[i][0] = X[i].x(), corner[i][1] = X[i].y();
  CREASE_ASSERT(double_area(corner[0], corner[1], corner[2]) > 0 && double_area(corner[1], corner[0], corner[3]) > 0);
  const HingeTerms<double> terms = hinge_terms(scaled(bending), corner[0], corner[1], corner[2], corner[3]);
  return {{terms.k[0], terms.k[1], terms.k[2], terms.k[3]}, terms.c};
}

}  // namespace crease
