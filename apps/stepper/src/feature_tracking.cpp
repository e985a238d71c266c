// SPDX-License-Identifier: MIT
#include "feature_tracking.hpp"

#include <algorithm>
#include <span>

#include "crease/geometry/wire.hpp"

namespace crease {
namespace {

/// Gap up to which an EOL vertex counts as standing on its feature, as a share of the contact threshold: far above
/// round-off, far below what is seen.
constexpr double closed_share = 1e-3;

/// Gap at which it has separated. In between it hovers: it keeps its five unknowns and its rows, which let it return,
/// so a fold that rattles by micrometres changes neither mesh nor state; moving it back by hand would strain the cloth.
constexpr double separated_share = 0.5;

/// Puts x back onto a plane n . (x - point) = 0 that it stands on but for round-off; the gap if it does not.
double settle(Vec3& x, const Vec3& point, const Vec3& n, double closed) {
  const double gap = n.dot(x - point);
  if (std::abs(gap) <= closed) x -= gap * n;
  return gap;
}

/// True if the vertex is still at its feature; x is put back onto every plane of the cone that it stands on.
bool stays(const SharpEdge& edge, const Pose& pose, double threshold, Vec3& x) {
  const Vec3 a = pose.to_world(edge.a), b = pose.to_world(edge.b);
  const double length = (b - a).norm(), along = (x - a).dot((b - a) / length);
  if (along < -closed_share * threshold || along > length + closed_share * threshold) return false;
  return std::all_of(edge.normals.begin(), edge.normals.end(), [&](const Vec3& n) {
    return settle(x, a, pose.rotation * n, closed_share * threshold) <= separated_share * threshold;
  });
}

bool stays(const SharpCorner& corner, const Pose& pose, double threshold, Vec3& x) {
  const Vec3 tip = pose.to_world(corner.position);
  return std::all_of(corner.normals.begin(), corner.normals.end(), [&](const Vec3& n) {
    return settle(x, tip, pose.rotation * n, closed_share * threshold) <= separated_share * threshold;
  });
}

/// As stays(), for a wire: the direction away from it is that of the cloth around the vertex.
bool stays_on_wire(Cloth& cloth, int vertex, const ObstacleShape& shape, const Pose& pose, double threshold) {
  const FeatureId id = cloth.feature[vertex];
  Vec3& x = cloth.mesh.x[vertex];
  Vec3 foot, tangent = Vec3::Zero();
  if (id.kind == FeatureKind::Edge) {
    const SharpEdge& edge = shape.edges[id.index];
    const double length = (edge.b - edge.a).norm();
    tangent = pose.rotation * (edge.b - edge.a) / length;
    const double along = (x - pose.to_world(edge.a)).dot(tangent);
    if (along < -closed_share * threshold || along > length + closed_share * threshold) return false;
    foot = pose.to_world(edge.a) + std::clamp(along, 0.0, length) * tangent;
  } else {
    foot = pose.to_world(shape.corners[id.index].position);
  }
  if ((x - foot).norm() <= closed_share * threshold) {
    x = foot;
    return true;
  }
  return wire_normal(cloth, vertex, tangent).dot(x - foot) <= separated_share * threshold;
}

}  // namespace

Pose mean_motion(const Obstacle& obstacle, double time, double h) {
  Pose pose = pose_at(obstacle, time);
  const Pose end = pose_at(obstacle, time + h);
  pose.velocity = (end.position - pose.position) / h;
  const bool turns = end.rotation != pose.rotation;  // else no round-off of R R^T
  pose.spin = turns ? Mat3((end.rotation * pose.rotation.transpose() - Mat3::Identity()) / h) : Mat3(Mat3::Zero());
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
    Vec3& x = cloth.mesh.x[v];
    const bool at_home = is_on_wire(id, shape)          ? stays_on_wire(cloth, v, shape, pose, threshold)
                         : id.kind == FeatureKind::Edge ? stays(shape.edges[id.index], pose, threshold, x)
                                                        : stays(shape.corners[id.index], pose, threshold, x);
    if (!at_home) leaving.push_back(v);
  }
  for (const int v : leaving) make_lagrangian(cloth, v);
  return static_cast<int>(leaving.size());
}

}  // namespace crease
