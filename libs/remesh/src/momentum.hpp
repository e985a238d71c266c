// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "crease/geometry/cloth.hpp"

// Momentum per unit density: integrals over the material of the world velocity w = xdot - F Xdot, linear on each face.
namespace crease {

struct Momentum {
  Vec3 linear = Vec3::Zero();   ///< integral of w [m^3/s]
  Vec3 angular = Vec3::Zero();  ///< integral of (x - about) x w, both linear on a face (consistent mass) [m^4/s]
};
inline Momentum operator-(const Momentum& a, const Momentum& b) {
  return {a.linear - b.linear, a.angular - b.angular};
}

Momentum momentum(const Cloth& cloth, std::span<const int> faces, const Vec3& about);
Vec3 total_linear_momentum(const Cloth& cloth);

/// Adds the rigid motion of the free vertices (Lagrangian, not pinned) among `vertices` that carries `debt`. Where they
/// do not fix a rigid motion, as three in a line, they take the linear part only; where none is free, their neighbours
/// pay.
void repay(Cloth& cloth, const Momentum& debt, const Vec3& about, std::vector<int> vertices);

}  // namespace crease
