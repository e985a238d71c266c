// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "border.hpp"
#include "crease/collision/contact.hpp"
#include "editor.hpp"
#include "features.hpp"

// The stages of conform(), in the order in which they run. All lengths are shares of the two that the user gives, so
// that a scene at another scale behaves the same.
namespace crease {

// -- shares of `merge` (material space)
// ---------------------------------------------------------------------------------
/// A chain this near to a border that runs along it, or to a material corner, is released.
inline constexpr double release_share = 0.35;
/// Nothing is inserted nearer to such a border than this: the gap to release_share is the hysteresis.
inline constexpr double insert_border_share = 0.5;
/// A crossing this near to an end of its cloth edge makes that end the EOL vertex, instead of a new one beside it.
inline constexpr double adopt_share = 0.25;
/// Neighbours on a chain nearer than this become one. Below sqrt(1 - thin_share^2): see merge.cpp.
inline constexpr double chain_merge_share = 0.75;
/// Triangles at a chain with less altitude than this are repaired.
inline constexpr double thin_share = 0.5;
/// ... by force, below this.
inline constexpr double forced_share = 0.3;
/// ... whatever it does to the surface, below this.
inline constexpr double last_share = 0.15;
/// What is left below this is reported.
inline constexpr double report_share = 0.2;
/// A chain stops this near to another one that it crosses, and begins again only where it is this far from it.
inline constexpr double cross_share = 0.35, cross_insert_share = 0.6;
// -- shares of `snap` (world)
// -------------------------------------------------------------------------------------------
/// A vertex begins to ride on a feature when the cloth has come nearer to it than this; it stays where the surface is,
/// and the solver's rows close the gap. Far below what ends the ride: the stepper releases at 0.5, from edges at 1.
inline constexpr double begin_share = 0.25;
/// The same beside two vertices that ride already: between them the cloth belongs to the chain.
inline constexpr double link_share = 0.45;
/// An EOL vertex farther than this from its feature has left it.
inline constexpr double leave_share = 2;
/// A feature stands back from one of an earlier obstacle within this; and, once its chain has begun, within less.
inline constexpr double aside_insert_share = 0.5, aside_share = 0.25;
/// A link may reach this far into a stretch that a chain has just left: vertices at its ends move.
inline constexpr double left_share = 0.01;
// -- strain
// ---------------------------------------------------------------------------------------------------------------
/// Energy that a patch may gain where a chain needs the change, but not at once: as a strain, see strain.hpp [1].
inline constexpr double needed_strain = 0.03;
// -- share of the border angle
// ------------------------------------------------------------------------------------------
/// A chain that meets the border at less than this share of the angle is released.
inline constexpr double release_angle_share = 0.75;

// -- share of what a vertex would reach in the time ahead
// ------------------------------------------------------------------
/// Way that a chain cannot do without: of seven steps 4.55, since one may cross 0.3 of a triangle and the next look is
/// a step away.
inline constexpr double need_share = 0.65;

/// What the stages share.
struct Conforming {
  Conforming(const Cloth& given, Obstacles obstacles_, const ConformOptions& options_)
      : editor(given), obstacles(obstacles_), options(options_), border(given.mesh) {}

  Editor editor;
  Obstacles obstacles;
  const ConformOptions& options;
  Border border;
  std::vector<int> newcomers;  ///< EOL vertices from contact, velocity not shared yet

  const Cloth& cloth() const { return editor.cloth(); }
  const Mesh& mesh() const { return editor.mesh(); }
  double merge(double share) const { return share * options.merge; }
  double left_between() const { return left_share * options.snap; }
  /// Cosine of a share of the border angle.
  double border_cosine(double share) const;
};

/// A point of the surface: where it is and how it moves.
struct SurfacePoint {
  Vec2 X;
  Vec3 x, v;
};
SurfacePoint on_edge_point(const Cloth& cloth, int h, double t);

/// Whether a chain of another feature, which comes first and does not meet this one in a corner, passes within `reach`
/// of P in a face of `vertex`. Where two chains cross no vertex can ride on both: the second one stops beside the
/// first.
bool passes_by(const Conforming& c, int vertex, const Vec2& P, const FeatureId& feature, double reach);

/// Whether another feature's chain ends at the border in `u`, within `reach` of P, which is on the border too.
bool ends_beside(const Conforming& c, int u, const Vec2& P, const FeatureId& feature, double reach);

// -- stages
// ---------------------------------------------------------------------------------------------------------------
void release_strays(Conforming& c);
/// Whether u rides on the feature too, in another place of it, and no link may join it to one at the point x for now.
bool is_parted(const Conforming& c, const FeatureId& feature, const Vec3& x, int u);
/// Ends the ride of a vertex: for a while no chain begins where it was.
void let_go(Conforming& c, int v);
/// Of two riders that have come to one place and are not linked, so that they cannot be merged, lets go of one, which
/// is then in the other's way like any free vertex: of v, or of another one beside it. Whether it did.
bool drop_second_rider(Conforming& c, int v);
void insert_contacts(Conforming& c, std::span<const Contact> contacts);
void connect_chains(Conforming& c);
void merge_near_chains(Conforming& c);
/// Eq. 13 for every vertex that became EOL in this call.
void share_velocities(Conforming& c);

// -- shared by insertion and connection
// -----------------------------------------------------------------------------------
/// Why no vertex may begin to ride on `feature` at the material point P, whose chain would run along `direction`.
/// `border_edge`: the border half-edge on which P lies, or none.
std::optional<RefusalReason> inadmissible(const Conforming& c, const Vec2& P, const Vec2& direction, int border_edge);
/// Whether the surface point is moving away from the feature, or along `normal` (the cloth's, turned away from the
/// obstacle; zero if unknown), and not inside the obstacle.
bool separates(const Conforming& c, const FeatureId& feature, const SurfacePoint& point, const Vec3& normal);
/// Makes `vertex` ride on the feature after sliding it to `point`; false where it may not move there.
/// @param along_border  the way there is a border edge
bool adopt(Conforming& c, int vertex, const SurfacePoint& point, const FeatureId& feature, bool along_border);
/// Splits edge h at t for a new vertex that rides on the feature; the vertex, or none.
int insert_on_edge(Conforming& c, int h, double t, const FeatureId& feature);

}  // namespace crease
