// SPDX-License-Identifier: MIT
#include "feature_cone.hpp"

#include "crease/base/require.hpp"

namespace crease {
namespace {

// Two unit vectors that complete `axis` to an orthonormal frame. Starts from the coordinate axis farthest from `axis`,
// so that no direction is degenerate.
std::vector<Vec3> across(const Vec3& axis) {
  int farthest = 0;
  axis.cwiseAbs().minCoeff(&farthest);
  const Vec3 first = axis.cross(Vec3::Unit(farthest)).normalized();
  return {first, axis.cross(first)};
}

// In the obstacle's own frame.
FeatureCone edge_cone(const SharpEdge& edge) {
  FeatureCone cone{.point = edge.a};
  cone.tangent = (edge.b - edge.a).normalized();
  if (edge.free_cone) {
    cone.holds = across(cone.tangent);
  } else {
    cone.normals.assign(edge.normals.begin(), edge.normals.end());
  }
  return cone;
}

// Three normals or more hold a vertex by themselves. The one normal of a nail's tip would let it slip off sideways, and
// the joint of a wire has none.
FeatureCone corner_cone(const SharpCorner& corner) {
  FeatureCone cone{.point = corner.position, .normals = corner.normals};
  if (corner.normals.size() == 1) {
    cone.holds = across(corner.normals.front());
  } else if (corner.normals.empty()) {
    cone.holds = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  }
  return cone;
}

}  // namespace

FeatureCone feature_cone(const FeatureId& feature, std::span<const PosedObstacle> obstacles) {
  const auto below = [](int index, std::size_t size) { return index >= 0 && static_cast<std::size_t>(index) < size; };
  require(below(feature.obstacle, obstacles.size()), "build_constraints: expected the feature of a given obstacle");
  const PosedObstacle& obstacle = obstacles[feature.obstacle];
  require(obstacle.shape != nullptr, "build_constraints: expected an obstacle with a shape");
  const ObstacleShape& shape = *obstacle.shape;
  const bool is_edge = feature.kind == FeatureKind::Edge;
  require(below(feature.index, is_edge ? shape.edges.size() : shape.corners.size()),
          "build_constraints: expected a feature that the obstacle has");

  FeatureCone cone = is_edge ? edge_cone(shape.edges[feature.index]) : corner_cone(shape.corners[feature.index]);
  cone.point = obstacle.pose.to_world(cone.point);
  for (Vec3& normal : cone.normals) normal = obstacle.pose.rotation * normal;
  for (Vec3& hold : cone.holds) hold = obstacle.pose.rotation * hold;
  cone.tangent = obstacle.pose.rotation * cone.tangent;
  return cone;
}

void lie_on(FeatureCone& cone, const Vec3& normal) {
  cone.normals = {normal};
  if (cone.tangent.isZero())
    cone.holds = across(normal);
  else
    cone.holds = {cone.tangent.cross(normal)};
}

}  // namespace crease
