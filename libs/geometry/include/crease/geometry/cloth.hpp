// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/geometry/feature.hpp"
#include "crease/geometry/mesh.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// A stretch of a sharp edge, or a corner, that a chain of the cloth has left a short while ago.
struct LeftStretch {
  FeatureId feature;
  double from = 0, to = 0;  ///< along the edge, see WorldEdge::parameter; 0 of a corner [m]
  double age = 0;           ///< time since [s]
};

/// One sheet: where it is, how it moves, and which of its vertices ride on an obstacle's sharp feature.
///
/// A vertex whose `feature` is set is an EOL vertex: its unknowns are (xdot, Xdot), 5 numbers. Every other vertex is
/// Lagrangian, 3 unknowns, V = 0. All arrays have one entry a vertex slot of `mesh`.
/// A mesh edge between two neighbours on an obstacle edge carries the mesh tag `edge_tag(feature of that edge)`.
struct Cloth {
  Mesh mesh;
  std::vector<Vec3> v;              ///< xdot: velocity of the vertex [m/s]
  std::vector<Vec2> V;              ///< Xdot: material velocity of the vertex [m/s]; zero unless EOL
  std::vector<FeatureId> feature;   ///< kind None = Lagrangian
  std::vector<std::uint64_t> pins;  ///< bit k set: held by pin k; such a vertex is never removed

  std::vector<LeftStretch> left = {};  ///< no chain begins there

  bool is_eol(int vertex) const { return feature[vertex].kind != FeatureKind::None; }
  /// An EOL vertex that its feature leads: neither has its fold lifted off nor does it linger.
  bool rides(int vertex) const { return is_eol(vertex) && !feature[vertex].lifted; }
  int n_eol() const;
  /// World velocity of the material at a vertex: xdot for a Lagrangian one, xdot - F Xdot (F area-weighted) for EOL.
  Vec3 world_velocity(int vertex) const;
};

/// A cloth at rest on `mesh`: all arrays sized, all vertices Lagrangian, no pins.
Cloth make_cloth(Mesh mesh);

/// Turns an EOL vertex into a Lagrangian one: xdot := xdot - F Xdot with the area-weighted F, which conserves linear
/// momentum exactly; Xdot := 0. Tags of its chain edges are cleared.
void make_lagrangian(Cloth& cloth, int vertex);

/// Mesh tag of the chain on obstacle edge `index` of obstacle `obstacle`, and back. Never 0.
int edge_tag(int obstacle, int index);
FeatureId tag_feature(int tag);

/// First broken invariant in words, or nothing: mesh.validate(), array sizes, finite numbers, V = 0 off EOL vertices,
/// no EOL vertex at a material corner or tied by a seam, tied vertices with the same velocity and pins, every tagged
/// edge ends in two EOL vertices that lie on that feature; times and stretches of what lingers and was left are finite,
/// not negative and in order, and only what is lifted lingers.
std::optional<std::string> validate(const Cloth& cloth);

/// The same, and that every feature that is named there is one of these obstacles', and nothing has been off its
/// feature or left for longer than `longest` [s].
std::optional<std::string> validate(const Cloth& cloth, std::span<const PosedObstacle> obstacles, double longest);

}  // namespace crease
