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
  double threshold = 1e-3;           ///< contact threshold: near obstacles the surface may move by half of it [m]
  bool conserve = true;              ///< flips and collapses keep momentum; false interpolates only, for comparison
};

struct ConformOptions {
  double snap = 1e-3;            ///< contact threshold; a feature nearer than a quarter of it is made conformal [m]
  double merge = 0.01;           ///< conformal vertices and others nearer than this in material space are merged [m]
  double border_angle_deg = 36;  ///< a chain meeting the border at less than this is not begun
  double look_ahead = 0;         ///< what a moving chain would reach in this time is cleared out of its way as well [s]
  double clearance = 0;          ///< ... but nothing farther from it than this [m]
  bool eulerian = true;          ///< new vertices on features get a material velocity; false for methods without one
};

enum class RefusalReason {
  BudgetSpent,
  WouldInvert,
  TooThin,
  NotConnected,
  NearBorder,
  AtCorner,
  Separating,  ///< the cloth moves away from the feature there
  WouldLoseChain,
  NotManifold,
  Pinned,
  WouldMoveSurface,
  NearObstacle,
  OnSeam
};
inline constexpr std::size_t n_refusal_reasons = 13;
const char* to_string(RefusalReason reason);

/// Something that could not be done, and where. The mesh is valid all the same; the next pass tries it anew.
struct Refusal {
  RefusalReason reason;
  int vertex = -1;  ///< new numbering, -1 if the place is no vertex
  Vec2 X = Vec2::Zero();
};

/// What a cloth carries, per unit density; w is the world velocity of the material.
struct Motion {
  double area = 0;              ///< of the material: mass [m^2]
  Vec3 centre = Vec3::Zero();   ///< of mass [m]
  Vec3 linear = Vec3::Zero();   ///< integral of w [m^3/s]
  Vec3 angular = Vec3::Zero();  ///< integral of (x - centre) cross w [m^4/s]
  double kinetic = 0;           ///< integral of w^2 / 2 [m^4/s^2]
};
Motion motion(const Cloth& cloth);

struct RemeshReport {
  bool changed = false;  ///< topology, EOL set or any position
  int inserted = 0;      ///< new EOL vertices from contact
  int released = 0;      ///< EOL vertices made Lagrangian
  int splits = 0, flips = 0, collapses = 0;
  std::vector<Refusal> refusals;  ///< NearBorder, AtCorner, OnSeam, Separating are rules, not trouble: at most one each
  /// Flips, collapses and thinnings of chains that were due but not allowed, by RefusalReason; they are tried again in
  /// every pass.
  std::array<int, n_refusal_reasons> kept_back{};
  std::vector<int> vertex_map;          ///< old -> new vertex (Mesh::none = gone); empty when nothing changed
  double smallest_angle = 0;            ///< of the material triangles [rad]
  Motion before, after;                 ///< equal if nothing changed
  Vec3 momentum_change = Vec3::Zero();  ///< after.linear - before.linear
};

struct RemeshResult {
  Cloth cloth;  ///< compact, valid
  RemeshReport report;
};

/// Sizing tensor of every vertex: e^T M e <= 1 says the material edge e is short enough [1/m^2].
std::vector<Mat2> sizing_field(const Cloth& cloth, const AdaptOptions& options);

/// Splits, flips and collapses until every metric edge length is at most 1 and no collapse is due. Chains (tagged
/// edges), pinned vertices, EOL vertices and the vertices where a border bends stay, but for one thing: a chain denser
/// than its sizes ask for loses inner vertices, by collapses along itself, and the others slide along it until its
/// edges there are even. Ends by construction: a budget of operations
/// proportional to the faces wanted; what was refused is reported. Free vertices slide ahead of a chain that comes
/// near; in a cloth without chains, where it is flat and its sizes are the coarsest, also to bring lengths below 1/2
/// back above it.
///
/// A pass moves no point of the surface by more than .15 of `threshold` (neighbours that slide together: a little more)
/// or .02 of the shortest edge. A split leaves the surface as it is, and its velocities too but beside a chain. All
/// keep linear momentum and never raise the kinetic energy. They keep angular momentum about the centre of mass
/// wherever some velocity field on the new surface has it at no more energy: a sheet that turns rigidly about its
/// centre and loses a bulge has none.
/// @param obstacles  whose sharp features must not change sides; without them only the surface's own shape is guarded
RemeshResult adapt(const Cloth& cloth, const AdaptOptions& options, std::span<const PosedObstacle> obstacles = {});

/// Makes every sharp feature that the cloth touches a chain of mesh edges through EOL vertices: inserts where
/// `contacts` say a feature is crossed near enough, connects, merges what is too near, repairs thin triangles, releases
/// EOL vertices that are no longer at home (their feature is gone, they stand at a material corner, or their
/// chain has come within `merge` of a border that runs along it). A new EOL vertex stays where the surface is, up to a
/// quarter of `snap` from its feature: the gap is the solver's to close. It takes the world velocity of the cloth
/// there, as much of it as possible in Xdot (Eq. 13 with the real A_eq). Momentum and energy are kept as by adapt().
/// What it releases from a feature that is still there it notes in Cloth::left, where no chain begins again: whoever
/// advances the cloth drops those notes when they are old enough.
RemeshResult conform(const Cloth& cloth, std::span<const Contact> contacts, std::span<const PosedObstacle> obstacles,
                     const ConformOptions& options);

/// Solves min |xdot_w + F Xdot|^2 subject to rows . Xdot = 0 (Eq. 13); world velocity is kept: xdot = xdot_w + F Xdot.
/// @param rows  0, 1 or 2 unit vectors in material space; with 2 independent ones Xdot = 0
Vec2 eulerian_share(const Vec3& world_velocity, const Mat32& F, std::span<const Vec2> rows);

}  // namespace crease
