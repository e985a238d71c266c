// SPDX-License-Identifier: MIT
#include "features.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace crease {

namespace {
// Edges nearer to parallel than this are in one line: sine of 2 degrees, as for contacts.
constexpr double parallel_sine = 0.0349;
}  // namespace

double stand_off(const FeatureId& feature, Obstacles obstacles, const Vec3& x) {
  const PosedObstacle& obstacle = obstacles[feature.obstacle];
  const Vec3 away = x - nearest_on(feature, obstacles, x);
  std::span<const Vec3> normals;
  if (feature.kind == FeatureKind::Corner) {
    normals = obstacle.shape->corners[feature.index].normals;
  } else if (const SharpEdge& edge = obstacle.shape->edges[feature.index]; !edge.free_cone) {
    normals = edge.normals;
  }
  if (normals.empty()) return away.norm();
  const Vec3 local = obstacle.pose.rotation.transpose() * away;
  if (normals.size() == 1) return std::copysign(away.norm(), normals.front().dot(local));
  double largest = normals.front().dot(local);
  for (const Vec3& n : normals) largest = std::max(largest, n.dot(local));
  return largest;
}

Vec3 velocity_at(const FeatureId& feature, Obstacles obstacles, const Vec3& x) {
  return obstacles[feature.obstacle].pose.velocity_at(x);
}

bool gives_way(const FeatureId& edge, const FeatureId& other, Obstacles obstacles) {
  if (std::pair(edge.obstacle, edge.index) <= std::pair(other.obstacle, other.index)) return false;
  if (edge.obstacle != other.obstacle) return true;
  const std::vector<SharpEdge>& edges = obstacles[edge.obstacle].shape->edges;
  for (const int corner : edges[edge.index].corners)
    if (corner >= 0 && (corner == edges[other.index].corners[0] || corner == edges[other.index].corners[1]))
      return false;
  return true;
}

bool stands_back(const FeatureId& feature, Obstacles obstacles, const Vec3& x, double reach) {
  const auto has_near = [&](int o, FeatureKind kind, std::size_t n, auto&& fits) {
    for (int i = 0; i < static_cast<int>(n); ++i)
      if (const FeatureId other{o, kind, i}; (nearest_on(other, obstacles, x) - x).norm() <= reach && fits(other))
        return true;
    return false;
  };
  const auto runs_along = [&](const FeatureId& other) {
    if (feature.kind != FeatureKind::Edge) return true;
    return world_edge(other, obstacles).tangent.cross(world_edge(feature, obstacles).tangent).norm() < parallel_sine;
  };
  const auto is_corner = [&](const FeatureId&) { return feature.kind == FeatureKind::Corner; };
  for (int o = 0; o < feature.obstacle; ++o) {
    const ObstacleShape& shape = *obstacles[o].shape;
    if (has_near(o, FeatureKind::Edge, shape.edges.size(), runs_along)) return true;
    if (has_near(o, FeatureKind::Corner, shape.corners.size(), is_corner)) return true;
  }
  return false;
}

Vec2 pull_back(const Mat32& F, const Vec3& d) {
  const Mat2 C = F.transpose() * F;
  const Vec2 right = F.transpose() * d;
  // The adjugate of C: only the direction is wanted, and the determinant may be small.
  const Vec2 t(C(1, 1) * right.x() - C(0, 1) * right.y(), C(0, 0) * right.y() - C(1, 0) * right.x());
  if (t.norm() > 0) return t.normalized();
  return right.norm() > 0 ? Vec2(right.normalized()) : Vec2(1, 0);
}

}  // namespace crease
