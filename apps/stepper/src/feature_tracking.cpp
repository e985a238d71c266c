// SPDX-License-Identifier: MIT
#include "feature_tracking.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "crease/geometry/chain.hpp"
#include "crease/geometry/triangle.hpp"
#include "crease/geometry/wire.hpp"

namespace crease {
namespace {

/// Gap up to which an EOL vertex counts as standing on its feature, as a share of the contact threshold: far above
/// round-off, far below what is seen.
constexpr double closed_share = 1e-3;

/// Gap at which it has separated. In between it hovers: it keeps its five unknowns and its rows, which let it return,
/// so a fold that rattles by micrometres changes neither mesh nor state; moving it back by hand would strain the cloth.
constexpr double separated_share = 0.5;
/// The same for an edge: its distance. Cloth that slides over an edge in a shallow fold rattles more than over a tip,
/// and each turn that it ends costs a chain.
constexpr double off_edge_share = 1;

/// A fold this sharp [rad] goes on as one when it lifts off, until it is flatter than that. Flat cloth has no fold to
/// follow, and x and X of a vertex in it could slide against each other.
constexpr double lift_angle = 0.3, flat_angle = 0.2;

/// A fold that nothing leads is a wave in the material, as fast as its tension makes it: T = rho V^2 across its chain.
/// Much faster it is none, as in cloth that has gone slack, where nothing would keep it in its place either. Nor does
/// it begin much slower: where an obstacle draws back from a fold at rest, that parts into two waves, which one chain
/// cannot be.
constexpr double fastest_share = 2, slowest_share = 0.5;

/// What lifts off rises by at least this over the way it goes; less is round-off of what slides.
constexpr double lifting_sine = 1e-3;

/// Puts x back onto a plane n . (x - point) = 0 that it stands on but for round-off; the gap if it does not.
double settle(Vec3& x, const Vec3& point, const Vec3& n, double closed) {
  const double gap = n.dot(x - point);
  if (std::abs(gap) <= closed) x -= gap * n;
  return gap;
}

/// The way from the edge to a vertex that has lifted off it, or may be about to.
struct LiftedWay {
  double distance, gap;  ///< from the edge; along the direction in which it pushes the cloth
  bool rises;            ///< along that direction
};

LiftedWay lifted_way(const Cloth& cloth, int vertex, const SharpEdge& edge, const Pose& pose) {
  const Vec3 tangent = pose.rotation * (edge.b - edge.a).normalized();
  const std::array<Vec3, 2> normals{pose.rotation * edge.normals[0], pose.rotation * edge.normals[1]};
  const Vec3 away = cloth.mesh.x[vertex] - pose.to_world(edge.a);
  const Vec3 across = away - away.dot(tangent) * tangent;
  const Vec3 motion = cloth.v[vertex] - pose.velocity_at(cloth.mesh.x[vertex]);
  const Vec3 normal = support_normal(cloth, vertex, tangent, normals);
  return {across.norm(), normal.dot(across), normal.dot(motion) > lifting_sine * motion.norm()};
}

/// rho V^2 / T of a fold, with the tension across its chain T = E (n^T F^T F n - 1)/2 in the mean of the faces, n the
/// material normal of the chain; infinite without tension.
double wave_share(const Cloth& cloth, int vertex, std::span<const PosedObstacle> obstacles, const Material& material) {
  const Mesh& mesh = cloth.mesh;
  const Vec2 t = chain_tangent(cloth, vertex, obstacles), n(t.y(), -t.x());
  double strain = 0, area = 0;
  for (const int h : mesh.outgoing(vertex)) {
    const int f = Mesh::face_of(h);
    strain += mesh.material_area(f) * ((deformation_gradient(mesh, f) * n).squaredNorm() - 1) / 2;
    area += mesh.material_area(f);
  }
  const double tension = material.youngs * strain / area, speed = n.dot(cloth.V[vertex]);
  return tension > 0 ? material.density * speed * speed / tension : std::numeric_limits<double>::infinity();
}

/// True if the vertex is still at its feature, or its fold goes on without it; x is put back onto every plane of the
/// cone that it stands on.
bool stays(Cloth& cloth, int vertex, std::span<const PosedObstacle> obstacles, const Material& material,
           double threshold) {
  const PosedObstacle& obstacle = obstacles[cloth.feature[vertex].obstacle];
  const SharpEdge& edge = obstacle.shape->edges[cloth.feature[vertex].index];
  const Pose& pose = obstacle.pose;
  Vec3& x = cloth.mesh.x[vertex];
  bool& lifted = cloth.feature[vertex].lifted;
  const double closed = closed_share * threshold, separated = separated_share * threshold;
  const Vec3 a = pose.to_world(edge.a), b = pose.to_world(edge.b);
  const double length = (b - a).norm(), along = (x - a).dot((b - a) / length);
  if (along < -closed || along > length + closed) return false;
  const LiftedWay way = lifted_way(cloth, vertex, edge, pose);
  const double angle = fold_angle(cloth, vertex);
  const double least_share = lifted ? 0.0 : slowest_share;
  if (lifted)
    lifted = angle > flat_angle && (way.gap > closed || way.distance > separated);
  else
    lifted = angle > lift_angle && way.gap > closed && way.rises;
  if (lifted) {
    const double share = wave_share(cloth, vertex, obstacles, material);
    lifted = share >= least_share && share <= fastest_share;
  }
  if (lifted) return true;
  for (const Vec3& n : edge.normals) settle(x, a, pose.rotation * n, closed);
  return way.distance <= off_edge_share * threshold;
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

/// Ends the ride of a vertex that has been away for too long; else it goes on as a Lagrangian one would, in its chain.
/// @return whether it has ended
bool leave(Cloth& cloth, int vertex, std::span<const PosedObstacle> obstacles, const Tracking& tracking) {
  FeatureId& feature = cloth.feature[vertex];
  feature.away += tracking.h;
  if (feature.away <= tracking.linger + tracking.h / 2) {
    feature.lifted = true;
    cloth.v[vertex] = cloth.world_velocity(vertex);
    cloth.V[vertex].setZero();
    return false;
  }
  if (tracking.linger > 0) {
    const std::vector<LeftStretch> left = stretches_at(cloth, vertex, obstacles);
    cloth.left.insert(cloth.left.end(), left.begin(), left.end());
  }
  make_lagrangian(cloth, vertex);
  return true;
}

void forget_left(Cloth& cloth, const Tracking& tracking) {
  for (LeftStretch& left : cloth.left) left.age += tracking.h;
  std::erase_if(cloth.left, [&](const LeftStretch& left) { return left.age > tracking.linger - tracking.h / 2; });
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

int track_features(Cloth& cloth, std::span<const Obstacle> obstacles, const Tracking& tracking) {
  const double threshold = tracking.threshold;
  std::vector<PosedObstacle> posed;
  for (const Obstacle& obstacle : obstacles) posed.push_back({&obstacle.shape, pose_at(obstacle, tracking.time)});
  forget_left(cloth, tracking);
  std::vector<int> leaving;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    if (!cloth.is_eol(v)) continue;
    FeatureId& id = cloth.feature[v];
    if (id.away > 0) id.lifted = false;  // there was no fold to follow: is it back?
    const ObstacleShape& shape = *posed[id.obstacle].shape;
    const Pose& pose = posed[id.obstacle].pose;
    const bool at_home = is_on_wire(id, shape) ? stays_on_wire(cloth, v, shape, pose, threshold)
                         : id.kind == FeatureKind::Edge
                             ? stays(cloth, v, posed, tracking.material, threshold)
                             : stays(shape.corners[id.index], pose, threshold, cloth.mesh.x[v]);
    if (at_home)
      id.away = 0;
    else
      leaving.push_back(v);
  }
  return static_cast<int>(
      std::count_if(leaving.begin(), leaving.end(), [&](int v) { return leave(cloth, v, posed, tracking); }));
}

}  // namespace crease
