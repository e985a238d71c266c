// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>

#include "crease/geometry/cloth.hpp"
#include "crease/remesh/remesh.hpp"
#include "surroundings.hpp"

// What an operation would make of the surface, found out before it is done.
namespace crease {

/// Faces may not get a smaller angle than this, unless it was smaller before [rad].
inline constexpr double least_angle = 0.14;  // 8 degrees
/// Two faces that meet at more than this in the world are a fold that a flip would cut through [rad].
inline constexpr double flip_dihedral = 0.35;  // 20 degrees
/// An operation may give its patch the energy of this strain, see strain.hpp [1]: a stiff sheet of E = 2000 N/m then
/// gains .004 J/m^2, as much as .05 kg/m^2 have at .4 m/s.
inline constexpr double unfelt_strain = 2e-3;

/// Where a vertex that is removed goes: into the vertex `a`, or, with `b` set, into a vertex that will be made on edge
/// ab. A vertex that stays and only slides along the surface has neither.
struct Target {
  Vec2 X;
  Vec3 x;
  int a = Mesh::none;
  int b = Mesh::none;
};
Target at_vertex(const Mesh& mesh, int vertex);
/// @param t  from a to b
Target on_edge(const Mesh& mesh, int a, int b, double t);

/// The faces round a vertex after it has gone to its target.
struct Ring {
  bool sound = true;                         ///< all of positive material area, none with three corners on one edge
  double altitude = 0, altitude_before = 0;  ///< smallest in material space [m]
  double angle = 0, angle_before = 0;        ///< smallest in material space [rad]
  double turn = 0;                           ///< largest turn of a face's world normal [rad]
  double shift = 0;                          ///< distance of the removed vertex from the surface that is left [m]
};
Ring ring_after(const Cloth& cloth, int vertex, const Target& target);
/// Ring::shift alone: most candidates on a curved sheet fail by it, and it costs little.
double left_behind(const Mesh& mesh, int vertex, const Target& target);

/// The two faces of an edge after a flip.
struct FlipCheck {
  bool sound = false;                        ///< Mesh::can_flip, and no face with three corners on one obstacle edge
  double altitude = 0, altitude_before = 0;  ///< smallest in material space [m]
  double angle = 0, angle_before = 0;        ///< smallest in material space [rad]
  double dihedral = 0;                       ///< between the two faces now, in the world [rad]
};
FlipCheck flip_check(const Cloth& cloth, int h);

/// How much an operation of adapt() may change the surface.
struct GuardLimits {
  double shift;  ///< by which it may move it [m]
  double turn;   ///< by which a collapse may turn a normal [rad]
  const Surroundings& surroundings;
};
/// Whether adapt() may do an operation.
struct Verdict {
  std::optional<RefusalReason> trouble;  ///< why not, if not
  double shift = 0;                      ///< by how much it moves the surface, if that is known [m]
};
/// The one place where that is decided. Faces may not get thinner than the worse of least_angle and what they are; the
/// surface moves little, and over no feature.
Verdict judge_flip(const Cloth& cloth, int h, const GuardLimits& limits);
Verdict judge_collapse(const Cloth& cloth, int vertex, int into, const GuardLimits& limits);
/// @param least_altitude  that its faces keep, or had less before [m]
Verdict judge_slide(const Cloth& cloth, int vertex, const Target& target, double least_altitude,
                    const GuardLimits& limits);

/// Whether the vertex is in a chain of the obstacle edge that `tag` names, or is the corner where it ends.
bool on_line(const Cloth& cloth, int vertex, int tag);
/// Whether one obstacle edge holds all three: such a face has no area in the world.
bool in_one_line(const Cloth& cloth, int a, int b, int c);

}  // namespace crease
