// SPDX-License-Identifier: MIT
#include "crease/geometry/feature_place.hpp"

#include <algorithm>

namespace crease {

bool exists(const FeatureId& feature, std::span<const PosedObstacle> obstacles) {
  if (feature.kind == FeatureKind::None || feature.obstacle < 0 || feature.index < 0) return false;
  if (feature.obstacle >= static_cast<int>(obstacles.size())) return false;
  const ObstacleShape& shape = *obstacles[feature.obstacle].shape;
  const std::size_t n = feature.kind == FeatureKind::Edge ? shape.edges.size() : shape.corners.size();
  return feature.index < static_cast<int>(n);
}

WorldEdge world_edge(const FeatureId& edge, std::span<const PosedObstacle> obstacles) {
  const PosedObstacle& obstacle = obstacles[edge.obstacle];
  const SharpEdge& local = obstacle.shape->edges[edge.index];
  const double length = (local.b - local.a).norm();
  return {obstacle.pose.to_world(local.a), obstacle.pose.rotation * (local.b - local.a) / length, length};
}

Vec3 nearest_on(const FeatureId& feature, std::span<const PosedObstacle> obstacles, const Vec3& x) {
  const PosedObstacle& obstacle = obstacles[feature.obstacle];
  if (feature.kind == FeatureKind::Corner)
    return obstacle.pose.to_world(obstacle.shape->corners[feature.index].position);
  const WorldEdge edge = world_edge(feature, obstacles);
  return edge.a + std::clamp(edge.parameter(x), 0.0, edge.length) * edge.tangent;
}

bool lies_on(const FeatureId& vertex, const FeatureId& edge, std::span<const PosedObstacle> obstacles) {
  if (vertex == edge) return true;
  if (vertex.kind != FeatureKind::Corner || vertex.obstacle != edge.obstacle) return false;
  const SharpEdge& local = obstacles[edge.obstacle].shape->edges[edge.index];
  return local.corners[0] == vertex.index || local.corners[1] == vertex.index;
}

}  // namespace crease
