// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "crease/geometry/cloth.hpp"
#include "crease/remesh/remesh.hpp"

// Momentum and energy per unit density: integrals over the material of the world velocity w = xdot - F Xdot, linear on
// each face (consistent mass).
namespace crease {

/// The frame in which an account is kept. One that moves with the cloth's mean velocity makes it the same for a cloth
/// at rest and one in free fall.
struct Frame {
  Vec3 origin, velocity;
};

/// What some faces carry, seen in the frame; angular momentum about its origin.
struct Account {
  double area = 0;
  Vec3 moment = Vec3::Zero();  ///< integral of x
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  double kinetic = 0;

  Account& operator+=(const Account& more);
};
Account account(const Cloth& cloth, std::span<const int> faces, const Frame& frame);

/// Rings of vertices round a patch that may pay for an operation. One in ten thousand needs more than three.
constexpr int paying_rings = 8;

/// Makes up for what an operation did to its patch: changes the velocities of the free vertices (Lagrangian, not
/// pinned or tied) among `patch`, by the least change of the velocity field, so that both momenta are as `before` and
/// the kinetic energy is not above it. Where they cannot, the vertices around them join in, ring by ring.
/// @param before, after  accounts of the patch in `frame`, before the operation and now
/// @param rings  at most so many
/// @return false if these cannot either: nothing is done then
bool settle(Cloth& cloth, const Account& before, const Account& after, const Frame& frame, std::vector<int> patch,
            int rings);
/// The same as far as they can then: the linear momentum comes before the angular one, and the energy before both.
void settle_in_part(Cloth& cloth, const Account& before, const Account& after, const Frame& frame,
                    std::vector<int> patch);

}  // namespace crease
