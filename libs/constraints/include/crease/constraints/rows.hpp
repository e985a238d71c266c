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
  EolNormal,   ///< n_k . xdot >= n_k . v_obstacle (- gap/h) at an EOL vertex; `slot` = k
  EolTangent,  ///< t . Xdot = 0, interior EOL vertex on an edge
  EolBorder,   ///< b . Xdot = 0, EOL vertex on the cloth's border
  EolHold,     ///< xdot held on a point or across a wire
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

/// A_eq qdot = b_eq, A_in qdot >= b_in (Eq. 12), and a small quadratic term that makes the minimiser unique.
struct ConstraintRows {
  SparseRows A_eq, A_in;
  VecX b_eq, b_in;
  std::vector<RowInfo> eq, in;
  /// scale m/2 (direction . xdot_vertex - value)^2 is added to the objective, m the lumped mass of the vertex. On flat
  /// cloth x and X of an EOL vertex slide against each other across its edge without moving any material, so that
  /// motion has no inertia, and any force along it blows it up. The term gives it some and leads the vertex back onto
  /// its edge: with h/t_r of m and -gap/t_r it is a drag of rate 1/t_r, independent of the step. Where the contact is
  /// active it changes nothing; cloth that lifts off feels it for its first fractions of a millimetre, with less than
  /// m gap / t_r^2.
  struct Regularisation {
    int vertex;
    Vec3 direction;
    double value;  ///< normal . v_obstacle - gap/t_r, the gap counted where it is open [m/s]
    double scale;  ///< h/t_r: share of the lumped mass of the vertex
  };
  std::vector<Regularisation> regularisation;
};

/// One pin, resolved to this instant.
struct PinState {
  int index = 0;  ///< bit in Cloth::pins
  std::array<bool, 3> axes{true, true, true};
  Vec3 velocity = Vec3::Zero();  ///< mean velocity over the coming step [m/s]
  bool released = false;
};

struct ConstraintOptions {
  double h = 0;               ///< time step [s], > 0
  double threshold = 1e-3;    ///< contact threshold [m]
  double return_time = 0.01;  ///< t_r > 0: a penetration is pushed out at threshold/t_r at most; see Regularisation [s]
};

/// Algorithm 2 of the paper with signs from the obstacle, border rule, Lagrangian contacts, pins, right-hand sides with
/// the obstacle's velocity and the gap. A pinned axis wins over an inequality it would contradict.
/// Rows are ordered by vertex, then kind; deterministic.
ConstraintRows build_constraints(const Cloth& cloth, const DofMap& dofs, std::span<const Contact> contacts,
                                 std::span<const PosedObstacle> obstacles, std::span<const PinState> pins,
                                 const ConstraintOptions& options);

}  // namespace crease
