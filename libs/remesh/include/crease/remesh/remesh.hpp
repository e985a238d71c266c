// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/collision/contact.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// Limits of the adaptive remesher; meanings as in ARCSim.                                         [NARAIN12]
struct AdaptOptions {
  std::array<double, 2> size{0, 0};  ///< shortest and longest edge [m]; required, size[1] >= size[0] > 0
  double angle = 0.3;                ///< normal change allowed along an edge [rad]
  double velocity = 0.5;             ///< velocity difference allowed along an edge, rigid rotation removed [m/s]
  double compression = 0.005;        ///< amplitude of the wrinkle that takes up a compression [m]
  double aspect = 0.2;               ///< smallest ratio of the metric's two lengths
};

struct ConformOptions {
  double snap = 1e-3;            ///< features nearer to the cloth than this are made conformal (contact threshold) [m]
  double merge = 0.01;           ///< conformal vertices and others nearer than this in material space are merged [m]
  double border_angle_deg = 36;  ///< a chain meeting the border at less than this is not begun
};

enum class RefusalReason { BudgetSpent, WouldInvert, TooThin, NotConnected, NearBorder, AtCorner, WouldLoseChain };
const char* to_string(RefusalReason reason);

/// Something that could not be done, and where; the caller slows the step and tries again.
struct Refusal {
  RefusalReason reason;
  int vertex = -1;  ///< new numbering, -1 if the place is no vertex
  Vec2 X = Vec2::Zero();
};

struct RemeshReport {
  bool changed = false;  ///< topology, EOL set or any position
  int inserted = 0;      ///< new EOL vertices from contact
  int released = 0;      ///< EOL vertices made Lagrangian
  int splits = 0, flips = 0, collapses = 0;
  std::vector<Refusal> refusals;  ///< NearBorder and AtCorner are rules, not trouble: at most one of each is listed
  std::vector<int> vertex_map;    ///< old -> new vertex (Mesh::none = gone); empty when nothing changed
  double smallest_angle = 0;      ///< of the material triangles [rad]
  Vec3 momentum_change = Vec3::Zero();  ///< linear, by the whole pass, per unit density [kg m/s / (kg/m^2)]
};

struct RemeshResult {
  Cloth cloth;  ///< compact, valid
  RemeshReport report;
};

/// Sizing tensor of every vertex: e^T M e <= 1 says the material edge e is short enough [1/m^2].
std::vector<Mat2> sizing_field(const Cloth& cloth, const AdaptOptions& options);

/// Splits, flips and collapses until every metric edge length is at most 1 and no collapse is due. Chains (tagged
/// edges), pinned vertices, EOL vertices and material corners stay, but for one thing: a chain denser than its sizes
/// ask for loses inner vertices, by collapses along itself. Ends by construction: a budget of operations proportional
/// to the faces wanted; what was refused is reported.
RemeshResult adapt(const Cloth& cloth, const AdaptOptions& options);

/// Makes every sharp feature that the cloth touches a chain of mesh edges through EOL vertices: inserts where
/// `contacts` say a feature is crossed nearer than `snap`, connects, merges what is too near, repairs thin triangles,
/// releases EOL vertices that are no longer at home (their feature is gone, they stand at a material corner, or their
/// chain has come within `merge` of a border that runs along it). New EOL vertices take the world velocity of the cloth
/// there, as much of it as possible in Xdot (Eq. 13 with the real A_eq).
RemeshResult conform(const Cloth& cloth, std::span<const Contact> contacts, std::span<const PosedObstacle> obstacles,
                     const ConformOptions& options);

/// Solves min |xdot_w + F Xdot|^2 subject to rows . Xdot = 0 (Eq. 13); world velocity is kept: xdot = xdot_w + F Xdot.
/// @param rows  0, 1 or 2 unit vectors in material space; with 2 independent ones Xdot = 0
Vec2 eulerian_share(const Vec3& world_velocity, const Mat32& F, std::span<const Vec2> rows);

}  // namespace crease
