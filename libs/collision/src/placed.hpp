// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include <Eigen/Geometry>

#include "crease/base/types.hpp"
#include "crease/geometry/normal_cone.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// A sharp or blunt edge in world coordinates.
struct PlacedEdge {
  Vec3 a = Vec3::Zero(), tangent = Vec3::Zero();  ///< start; unit vector from a to b
  double length = 0;                              ///< [m]
  std::array<Vec3, 2> normals;
  Vec3 mean = Vec3::Zero();
  bool free_cone = false;
  double tolerance = cone_tolerance;  ///< by which a normal may leave the cone [rad]
  std::array<int, 2> corners{-1, -1};
};

/// A sharp corner in world coordinates.
struct PlacedCorner {
  Vec3 position = Vec3::Zero(), mean = Vec3::Zero();
  std::vector<Vec3> normals;
};

/// One obstacle where it is, its features turned into world coordinates once a call.
struct PlacedObstacle {
  int index = -1;
  PosedObstacle source;
  std::vector<PlacedEdge> edges, blunt_edges;
  std::vector<PlacedCorner> corners;
  std::vector<FacePlane> faces;  ///< of a convex solid with few; else empty
  bool has_surface = false;
  Eigen::AlignedBox3d bounds;
};

/// Where the obstacle is after h seconds of this motion.
Pose pose_after(const Pose& pose, double h);

PlacedObstacle place(const PosedObstacle& obstacle, int index);

}  // namespace crease
