// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "crease/base/types.hpp"
#include "crease/geometry/closed_surface.hpp"
#include "crease/geometry/feature.hpp"

namespace crease {

/// One face of a convex solid {p : normal . p <= offset for all faces}.
struct FacePlane {
  Vec3 normal = Vec3::Zero();
  double offset = 0;
};

/// A shape in its own frame: a surface to stay outside of, and the sharp features on it.
///
/// All shapes share this description, so that no later stage knows what it was made from: a box has 12 triangles, 8
/// corners and 12 edges; a nail one corner and no surface; a wire edges and no surface; a closed mesh the edges sharper
/// than a given angle.
struct ObstacleShape {
  enum class Kind { Box, Point, Wire, Mesh };
  Kind kind = Kind::Box;
  Vec3 half_size = Vec3::Zero();  ///< Box only [m]
  std::vector<Vec3> vertices;
  std::vector<std::array<int, 3>> triangles;  ///< outward orientation
  std::vector<SharpCorner> corners;
  std::vector<SharpEdge> edges;
  /// Mesh only: what bends outwards less than the sharp angle. No vertex rides there, but it holds up a cloth edge that
  /// lies across. One a mesh edge, without corners.
  std::vector<SharpEdge> blunt_edges;
  std::vector<FacePlane> planes;  ///< of a convex solid with few faces and no acute edge, local; else empty
  /// Mesh only: its surface for queries, and where the features are on it.
  std::shared_ptr<const ClosedSurface> surface;
  std::vector<int> patch;  ///< of each triangle; sharp edges, bent outwards or inwards, part the surface into patches
  std::vector<std::array<int, 3>> edge_at;  ///< of each triangle: index into `edges` on its side k, or -1
  std::vector<int> corner_at;               ///< of each vertex: index into `corners`, or -1
};

/// Axis-aligned box about the origin. @pre size > 0
ObstacleShape make_box(const Vec3& size);

/// The tip of a nail at the origin; the cloth stays on the side of `normal`, of any length but 0. No surface.
ObstacleShape make_point(const Vec3& normal);

/// A polyline without thickness: one edge a segment, and a corner with no normals at every joint. The two ends of an
/// open wire are no corners: there the cloth slips off. First and last point equal: a loop, closed by one more joint.
/// @pre two points or more, each unlike the one before it
ObstacleShape make_wire(const std::vector<Vec3>& points);

/// A closed triangle mesh. Edges that bend outwards by more than `sharp_angle` [rad] become features, a straight run of
/// them one; so do the corners in which they end, if a sheet can rest on them in more ways than one: at a corner whose
/// outward normals leave it no room, as where a ridge runs into a wall, an edge just ends. Edges that bend
/// outwards less are blunt edges, those that bend inwards are surface and nothing else; so is the tip of a cone that is
/// round enough to have no sharp edge. Vertices of no triangle are dropped. Throws std::invalid_argument with the first
/// of surface_problems().  @pre sharp_angle > 0
ObstacleShape make_mesh(const TriangleSurface& surface, double sharp_angle);

/// Velocity that holds until the next entry.
struct MotionKey {
  double time = 0;                       ///< [s]
  Vec3 velocity = Vec3::Zero();          ///< [m/s]
  Vec3 angular_velocity = Vec3::Zero();  ///< about the obstacle's own position, world axes [rad/s]
};

/// [a]x: cross_matrix(a) * b = a x b.
inline Mat3 cross_matrix(const Vec3& a) {
  return Mat3{{0, -a.z(), a.y()}, {a.z(), 0, -a.x()}, {-a.y(), a.x(), 0}};
}

/// Where a rigid obstacle is and how it moves: at an instant, where `spin` is [omega]x, or in the mean over a step h,
/// where it is (R(t+h) R(t)^T - 1) / h, so that p + h velocity_at(p) is where the obstacle's point p ends up, exactly.
struct Pose {
  Vec3 position = Vec3::Zero();
  Mat3 rotation = Mat3::Identity();
  Vec3 velocity = Vec3::Zero();
  Mat3 spin = Mat3::Zero();  ///< velocity gradient [1/s]
  Vec3 to_world(const Vec3& p) const { return position + rotation * p; }
  Vec3 to_local(const Vec3& p) const { return rotation.transpose() * (p - position); }
  /// World velocity of the obstacle's material at world point p.
  Vec3 velocity_at(const Vec3& p) const { return velocity + spin * (p - position); }
  /// The obstacle's direction d after h seconds; a unit vector stays one if the motion is the mean over h.
  Vec3 turned(const Vec3& d, double h) const { return d + h * (spin * d); }
};

struct Obstacle {
  std::string name;
  ObstacleShape shape;
  Pose start;                     ///< pose at time 0 (its velocities are ignored: see motion)
  std::vector<MotionKey> motion;  ///< ascending times; empty = at rest
};

/// Exact pose at a time: piecewise constant twist about the moving position.
Pose pose_at(const Obstacle& obstacle, double time);

/// An obstacle where it is now; the shape must outlive it.
struct PosedObstacle {
  const ObstacleShape* shape = nullptr;
  Pose pose;
};

/// Signed distance of a world point to the obstacle's surface, negative inside [m]; std::nullopt if the shape has no
/// surface (points, wires).
std::optional<double> signed_distance(const ObstacleShape& shape, const Pose& pose, const Vec3& p);

}  // namespace crease
