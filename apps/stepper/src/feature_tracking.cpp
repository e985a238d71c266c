// SPDX-License-Identifier: MIT
#include "feature_tracking.hpp"

#include <algorithm>
#include <limits>

#include "crease/geometry/chain.hpp"
#include "crease/geometry/triangle.hpp"
#include "crease/remesh/remesh.hpp"

namespace crease {
namespace {

/// Opening below which a vertex counts as on its feature, as a share of the contact threshold: far above round-off and
/// the regularised motion of a flat cloth, far below what is seen.
constexpr double closed_share = 1e-3;

/// Share of its material area that every triangle must keep when a vertex is seated again.
constexpr double min_area_share = 0.5;

/// Where a vertex stands with respect to its feature.
struct Stand {
  bool beyond_end = false;
  int n_normals = 0, n_open = 0;
  double opening = 0;        ///< largest distance along a normal of the cone [m]
  Vec3 home = Vec3::Zero();  ///< nearest place on the feature
};

void look_at_normals(Stand& stand, std::span<const Vec3> normals, const Pose& pose, const Vec3& offset, double closed) {
  for (const Vec3& n : normals) {
    const double gap = offset.dot(pose.rotation * n);
    ++stand.n_normals;
    if (gap > closed) ++stand.n_open;
    stand.opening = std::max(stand.opening, gap);
  }
}

Stand stand_on(const SharpEdge& edge, const Pose& pose, const Vec3& x, double closed) {
  Stand stand;
  const Vec3 a = pose.to_world(edge.a), b = pose.to_world(edge.b);
  const Vec3 t = (b - a).normalized();
  const double along = (x - a).dot(t), length = (b - a).norm();
  stand.beyond_end = along < -closed || along > length + closed;
  stand.home = a + std::clamp(along, 0.0, length) * t;
  if (!edge.free_cone) look_at_normals(stand, edge.normals, pose, x - a, closed);
  return stand;
}

Stand stand_on(const SharpCorner& corner, const Pose& pose, const Vec3& x, double closed) {
  Stand stand;
  stand.home = pose.to_world(corner.position);
  look_at_normals(stand, corner.normals, pose, x - stand.home, closed);
  return stand;
}

/// Pseudo-inverse F^+ d: the material displacement whose image is nearest to the world displacement d.
Vec2 pull_back(const Mat32& F, const Vec3& d) {
  const Mat2 C = F.transpose() * F;
  const double det = C.determinant();
  if (!(det > 1e-12 * C.trace() * C.trace())) return Vec2::Zero();
  return C.inverse() * (F.transpose() * d);
}

/// Material displacement that keeps the surface where it is when the vertex moves by dx: that of the incident face in
/// whose plane dx lies best.
Vec2 slide_in_surface(const Mesh& mesh, int vertex, const Vec3& dx) {
  double best = std::numeric_limits<double>::infinity();
  Vec2 dX = Vec2::Zero();
  for (const int h : mesh.outgoing(vertex)) {
    const Mat32 F = deformation_gradient(mesh, Mesh::face_of(h));
    const Vec2 candidate = pull_back(F, dx);
    const double residual = (F * candidate - dx).norm();
    if (residual < best) best = residual, dX = candidate;
  }
  if (mesh.is_border_vertex(vertex)) {
    const Vec2 b = border_normal(mesh, vertex);
    dX -= dX.dot(b) * b;
  }
  return dX;
}

/// Moves the vertex back to `home` along the surface: the fold that has opened by a hair is a matter of where on the
/// cloth the vertex sits, not of contact. World velocity stays, most of it in Xdot (Eq. 13). False if a triangle would
/// suffer; then nothing has changed.
bool seat_again(Cloth& cloth, int vertex, const Vec3& home, const Vec3& obstacle_velocity,
                std::span<const PosedObstacle> posed) {
  Mesh& mesh = cloth.mesh;
  const std::vector<int> fan = mesh.outgoing(vertex);
  std::vector<double> areas;
  for (const int h : fan) areas.push_back(mesh.material_area(Mesh::face_of(h)));
  const Vec2 X_before = mesh.X[vertex];
  mesh.X[vertex] += slide_in_surface(mesh, vertex, home - mesh.x[vertex]);
  for (std::size_t i = 0; i < fan.size(); ++i)
    if (!(mesh.material_area(Mesh::face_of(fan[i])) >= min_area_share * areas[i])) {
      mesh.X[vertex] = X_before;
      return false;
    }
  const Vec3 world_velocity = cloth.world_velocity(vertex);
  mesh.x[vertex] = home;
  const Mat32 F = vertex_deformation_gradient(mesh, vertex);
  const std::vector<Vec2> rows = eulerian_rows(cloth, vertex, posed);
  cloth.V[vertex] = eulerian_share(world_velocity - obstacle_velocity, F, rows);
  cloth.v[vertex] = world_velocity + F * cloth.V[vertex];
  return true;
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
  std::vector<PosedObstacle> posed;
  for (const Obstacle& obstacle : obstacles) posed.push_back({&obstacle.shape, pose_at(obstacle, time)});
  const double closed = closed_share * threshold;
  std::vector<int> leaving;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    if (!cloth.is_eol(v)) continue;
    const FeatureId id = cloth.feature[v];
    const ObstacleShape& shape = *posed[id.obstacle].shape;
    const Pose& pose = posed[id.obstacle].pose;
    const Vec3 x = cloth.mesh.x[v];
    const Stand stand = id.kind == FeatureKind::Edge ? stand_on(shape.edges[id.index], pose, x, closed)
                                                     : stand_on(shape.corners[id.index], pose, x, closed);
    if (!stand.beyond_end && stand.n_open == 0)
      cloth.mesh.x[v] = stand.home;
    else if (stand.beyond_end || stand.n_open == stand.n_normals || stand.opening > threshold ||
             !seat_again(cloth, v, stand.home, pose.velocity_at(stand.home), posed))
      leaving.push_back(v);
  }
  for (const int v : leaving) make_lagrangian(cloth, v);
  return static_cast<int>(leaving.size());
}

}  // namespace crease
