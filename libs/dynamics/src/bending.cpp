// SPDX-License-Identifier: MIT
#include "crease/dynamics/bending.hpp"

#include "crease/base/require.hpp"
#include "element.hpp"

namespace crease {

namespace {

// Times 3 s = 1: the energy 3 B/(A_0 + A_1) of the literature bends like a plate of 3 B on an equilateral mesh.
constexpr double plate_scale = 1.0 / 3.0;  // s [1]

// Cotangent of the angle at p in a counter-clockwise triangle p, q, r of twice the area `double_area`.
double cotangent(const Vec2& p, const Vec2& q, const Vec2& r, double double_area) {
  return (q - p).dot(r - p) / double_area;
}

}  // namespace

BendingElement bending_element(const std::array<Vec2, 4>& X, double bending) {
  const auto& [from, to, left, right] = X;
  const double double_left = 2 * material_area({from, to, left});
  const double double_right = 2 * material_area({to, from, right});
  CREASE_ASSERT(double_left > 0 && double_right > 0);
  const double from_left = cotangent(from, to, left, double_left), to_left = cotangent(to, left, from, double_left);
  const double from_right = cotangent(from, right, to, double_right),
               to_right = cotangent(to, from, right, double_right);
  BendingElement element;
  element.k << to_left + to_right, from_left + from_right, -(from_left + to_left), -(from_right + to_right);
  element.c = 3 * plate_scale * bending / (0.5 * (double_left + double_right));
  return element;
}

}  // namespace crease
