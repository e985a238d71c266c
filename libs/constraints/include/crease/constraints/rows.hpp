// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/collision/contact.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/dof_map.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

enum class RowKind {
  Pin,         ///< xdot . axis = scripted velocity
  EolNormal,   ///< N . xdot >= N . v_obstacle - gap/h at an EOL vertex, N the cloth's normal in the feature's cone
  EolTangent,  ///< t . Xdot = 0, interior EOL vertex on an edge
  EolBorder,   ///< b . Xdot = 0, EOL vertex on the cloth's border
  EolHold,     ///< xdot held across N
  Contact      ///< n . (sum w_i xdot_i) >= n . v_obstacle - gap/h, Lagrangian vertices
};

/// Where a row came from: enough to read its multiplier and to carry its activity to the next step.
struct RowInfo {
  RowKind kind = RowKind::Contact;
  int vertex = -1;  ///< the vertex; the lowest of those that take part
  FeatureId feature;
  int slot = 0;  ///< which normal / which axis
  Vec3 normal = Vec3::Zero();
};

/// A_eq qdot = b_eq, A_in qdot >= b_in (Eq. 12).
struct ConstraintRows {
  SparseRows A_eq, A_in;
  VecX b_eq, b_in;
  std::vector<RowInfo> eq, in;
};

/// One pin, resolved to this instant.
struct PinState {
  int index = 0;  ///< bit in Cloth::pins
  std::array<bool, 3> axes{true, true, true};
  Vec3 velocity = Vec3::Zero();  ///< mean velocity over the coming step [m/s]
  bool released = false;
};

struct ConstraintOptions {
  double h = 0;                 ///< time step [s], > 0
  double push_out_speed = 0.1;  ///< at which a penetration, or an EOL vertex off its place, is led back at most [m/s]
  /// Distance that a sheet keeps from a wire it only touches: a wire has no inside, so that the next step knows the
  /// side by nothing else [m].
  double wire_clearance = 0;
  /// By vertex: EOL vertices whose material coordinates stay as they are, Xdot = 0; empty: none.
  std::vector<char> held = {};
};

/// Algorithm 2 of the paper with signs from the obstacle, border rule, Lagrangian contacts, pins, right-hand sides with
/// the obstacle's velocity and the gap. A pinned axis wins over an inequality it would contradict.
/// Directions are those at the end of the step, as the obstacles' motion turns them (Pose::turned), so that what slides
/// on a turning face ends up on it; gaps are measured at the start.
/// Rows are ordered by vertex, then kind; deterministic.
ConstraintRows build_constraints(const Cloth& cloth, const DofMap& dofs, std::span<const Contact> contacts,
                                 std::span<const PosedObstacle> obstacles, std::span<const PinState> pins,
                                 const ConstraintOptions& options);

}  // namespace crease
