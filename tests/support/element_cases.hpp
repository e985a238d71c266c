// SPDX-License-Identifier: MIT
#pragma once

// Random triangles, rotations and finite differences for tests of element formulas.

#include <array>
#include <random>

#include <Eigen/Geometry>

#include "crease/base/types.hpp"

namespace crease::testing {

class Rng {
 public:
  explicit Rng(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  int index(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
  Vec2 vec2(double scale = 1) { return {uniform(-scale, scale), uniform(-scale, scale)}; }
  Vec3 vec3(double scale = 1) { return {uniform(-scale, scale), uniform(-scale, scale), uniform(-scale, scale)}; }
  Mat3 rotation() {
    return Eigen::Quaterniond(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(0.1, 1)).normalized().matrix();
  }

 private:
  std::mt19937_64 engine_;
};

/// Counter-clockwise, angles between about 30 and 100 degrees, size about 1.
inline std::array<Vec2, 3> random_material_triangle(Rng& rng) {
  return {Vec2(0, 0) + rng.vec2(0.15), Vec2(1, 0.1) + rng.vec2(0.15), Vec2(0.2, 0.9) + rng.vec2(0.15)};
}

/// A triangle deformed by an F near a rotation, stretched by up to `strain`.
inline std::array<Vec3, 3> random_world_triangle(const std::array<Vec2, 3>& X, double strain, Rng& rng) {
  Mat32 F = rng.rotation().leftCols<2>();
  for (int i = 0; i < 6; ++i) F(i % 3, i / 3) += rng.uniform(-strain, strain);
  const Vec3 offset = rng.vec3();
  return {offset + F * X[0], offset + F * X[1], offset + F * X[2]};
}

/// Fourth-order central difference of a function of one number at 0; truncation ~ step^4, rounding ~ eps/step.
template <typename Function>
auto central_difference(const Function& value, double step) {
  using Value = std::decay_t<decltype(value(step))>;
  const Value near = value(step) - value(-step), far = value(2 * step) - value(-2 * step);
  return Value((8 * near - far) / (12 * step));
}

}  // namespace crease::testing
