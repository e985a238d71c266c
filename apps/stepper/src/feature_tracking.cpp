// SPDX-License-Identifier: MIT
#include "feature_tracking.hpp"

#include <algorithm>
#include <optional>

namespace crease {
namespace {

/// Opening at which a vertex counts as separated, as a share of the contact threshold: far above round-off and the
/// regularised motion of a flat cloth, far below what is seen.
constexpr double release_share = 1e-3;

/// Where on its feature the vertex belongs, or nothing if it has left it.
std::optional<Vec3> home(const SharpEdge& edge, const Pose& pose, const Vec3& x, double opening) {
  const Vec3 a = pose.to_world(edge.a), b = pose.to_world(edge.b);
  const Vec3 t = (b - a).normalized();
  const double along = (x - a).dot(t), length = (b - a).norm();
  if (along < -opening || along > length + opening) return std::nullopt;
  if (!edge.free_cone)
    for (const Vec3& n : edge.normals)
      if ((x - a).dot(pose.rotation * n) > opening) return std::nullopt;
  return a + std::clamp(along, 0.0, length) * t;
}

std::optional<Vec3> home(const SharpCorner& corner, const Pose& pose, const Vec3& x, double opening) {
  const Vec3 tip = pose.to_world(corner.position);
  for (const Vec3& n : corner.normals)
    if ((x - tip).dot(pose.rotation * n) > opening) return std::nullopt;
  return tip;
}

}  // namespace

Pose mean_motion(const Obstacle& obstacle, double time, double h) {
  Pose pose = pose_at(obstacle, time);
  const Pose end = pose_at(obstacle, time + h);
  pose.velocity = (end.position - pose.position) / h;
  const Eigen::AngleAxisd turn(Mat3(end.rotation * pose.rotation.transpose()));
  pose.angular_velocity = turn.angle() / h * turn.axis();
  return pose;
}

int track_features(Cloth& cloth, std::span<const Obstacle> obstacles, double time, double threshold) {
  std::vector<Pose> poses;
  for (const Obstacle& obstacle : obstacles) poses.push_back(pose_at(obstacle, time));
  std::vector<int> leaving;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    if (!cloth.is_eol(v)) continue;
    const FeatureId id = cloth.feature[v];
    const ObstacleShape& shape = obstacles[id.obstacle].shape;
    const Pose& pose = poses[id.obstacle];
    const double opening = release_share * threshold;
    const auto place = id.kind == FeatureKind::Edge ? home(shape.edges[id.index], pose, cloth.mesh.x[v], opening)
                                                    : home(shape.corners[id.index], pose, cloth.mesh.x[v], opening);
    if (place)
      cloth.mesh.x[v] = *place;
    else
      leaving.push_back(v);
  }
  for (const int v : leaving) make_lagrangian(cloth, v);
  return static_cast<int>(leaving.size());
}

}  // namespace crease
