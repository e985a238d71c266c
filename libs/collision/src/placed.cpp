// SPDX-License-Identifier: MIT
#include "placed.hpp"

#include <algorithm>
#include <cmath>

#include "crease/base/require.hpp"
#include "crease/geometry/normal_cone.hpp"

namespace crease {
namespace {

PlacedCorner place_corner(const SharpCorner& corner, const Pose& pose) {
  PlacedCorner placed;
  placed.position = pose.to_world(corner.position);
  for (const Vec3& n : corner.normals) placed.normals.push_back(pose.rotation * n);
  placed.mean = mean_normal(placed.normals);
  return placed;
}

PlacedEdge place_edge(const SharpEdge& edge, const Pose& pose) {
  PlacedEdge placed;
  placed.a = pose.to_world(edge.a);
  placed.tangent = pose.rotation * (edge.b - edge.a);
  placed.length = placed.tangent.norm();
  if (placed.length > 0) placed.tangent /= placed.length;
  placed.free_cone = edge.free_cone;
  placed.corners = edge.corners;
  if (!edge.free_cone) {
    placed.normals = {pose.rotation * edge.normals[0], pose.rotation * edge.normals[1]};
    placed.mean = mean_normal(placed.normals);
  }
  return placed;
}

}  // namespace

Pose pose_after(const Pose& pose, double h) {
  Pose after = pose;
  after.position += h * pose.velocity;
  after.rotation += h * pose.spin * pose.rotation;
  return after;
}

PlacedObstacle place(const PosedObstacle& obstacle, int index) {
  const ObstacleShape& shape = *obstacle.shape;
  require(shape.kind != ObstacleShape::Kind::Mesh || shape.surface, "collision: expected a mesh made by make_mesh");
  PlacedObstacle placed;
  placed.index = index;
  placed.source = obstacle;
  for (const Vec3& p : shape.vertices) placed.bounds.extend(obstacle.pose.to_world(p));
  for (const SharpCorner& corner : shape.corners) {
    placed.corners.push_back(place_corner(corner, obstacle.pose));
    placed.bounds.extend(placed.corners.back().position);
  }
  for (const SharpEdge& edge : shape.edges) {
    placed.edges.push_back(place_edge(edge, obstacle.pose));
    placed.bounds.extend(placed.edges.back().a);
    placed.bounds.extend(obstacle.pose.to_world(edge.b));
  }
  for (const SharpEdge& edge : shape.blunt_edges) {
    PlacedEdge& blunt = placed.blunt_edges.emplace_back(place_edge(edge, obstacle.pose));
    // Else an edge of the cloth on a finely meshed round would touch all that bends within the tolerance.
    const double bend =
        std::atan2(blunt.normals[0].cross(blunt.normals[1]).norm(), blunt.normals[0].dot(blunt.normals[1]));
    blunt.tolerance = std::min(cone_tolerance, bend);
  }
  for (const FacePlane& plane : shape.planes) {
    const Vec3 normal = obstacle.pose.rotation * plane.normal;
    placed.faces.push_back({normal, normal.dot(obstacle.pose.position) + plane.offset});
  }
  placed.has_surface = !shape.triangles.empty();
  return placed;
}

}  // namespace crease
