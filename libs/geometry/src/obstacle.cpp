// SPDX-License-Identifier: MIT
#include "crease/geometry/obstacle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "crease/base/require.hpp"

namespace crease {
namespace {

// Corner c of a box has bit k of c set where its coordinate k is positive.
Vec3 box_corner(const Vec3& half_size, int c) {
  return {(c & 1) ? half_size.x() : -half_size.x(), (c & 2) ? half_size.y() : -half_size.y(),
          (c & 4) ? half_size.z() : -half_size.z()};
}

Vec3 axis_normal(int axis, bool positive) {
  return positive ? Vec3::Unit(axis) : Vec3(-Vec3::Unit(axis));
}

// Two outward triangles a face; the quad runs counter-clockwise seen from outside.
void add_box_triangles(ObstacleShape& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const int b = 1 << ((axis + 1) % 3), c = 1 << ((axis + 2) % 3);
    for (int side = 0; side < 2; ++side) {
      const int o = side << axis;
      if (side == 1) {
        box.triangles.push_back({o, o + b, o + b + c});
        box.triangles.push_back({o, o + b + c, o + c});
      } else {
        box.triangles.push_back({o, o + b + c, o + b});
        box.triangles.push_back({o, o + c, o + b + c});
      }
    }
  }
}

// Edge 4 axis + i runs along +axis; bits 0 and 1 of i say on which side of the two other axes, in cyclic order.
void add_box_edges(ObstacleShape& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    for (int i = 0; i < 4; ++i) {
      const int from = ((i & 1) << b) | ((i >> 1) << c), to = from | (1 << axis);
      SharpEdge edge;
      edge.a = box.corners[static_cast<std::size_t>(from)].position;
      edge.b = box.corners[static_cast<std::size_t>(to)].position;
      edge.normals = {axis_normal(b, (i & 1) != 0), axis_normal(c, (i & 2) != 0)};
      edge.corners = {from, to};
      box.edges.push_back(edge);
    }
  }
}

double box_signed_distance(const Vec3& half_size, const Vec3& p) {
  const Vec3 excess = p.cwiseAbs() - half_size;
  const double outside = excess.cwiseMax(0.0).norm();
  return outside > 0 ? outside : excess.maxCoeff();
}

// The constant twist (velocity, angular_velocity) acting for dt seconds: translation, and the exponential about world
// axes.
void move(Pose& pose, const MotionKey& key, double dt) {
  pose.position += dt * key.velocity;
  const double speed = key.angular_velocity.norm();
  if (speed > 0) pose.rotation = Eigen::AngleAxisd(speed * dt, key.angular_velocity / speed) * pose.rotation;
}

}  // namespace

ObstacleShape make_box(const Vec3& size) {
  require(size.allFinite() && (size.array() > 0).all(), "make_box: expected three finite sizes > 0");
  ObstacleShape box;
  box.kind = ObstacleShape::Kind::Box;
  box.half_size = 0.5 * size;
  for (int c = 0; c < 8; ++c) {
    box.vertices.push_back(box_corner(box.half_size, c));
    box.corners.push_back({box.vertices.back(),
                           {axis_normal(0, (c & 1) != 0), axis_normal(1, (c & 2) != 0), axis_normal(2, (c & 4) != 0)}});
  }
  add_box_triangles(box);
  add_box_edges(box);
  for (int axis = 0; axis < 3; ++axis)
    for (const bool positive : {false, true}) box.planes.push_back({axis_normal(axis, positive), box.half_size[axis]});
  return box;
}

ObstacleShape make_point(const Vec3& normal) {
  // By the largest component first: the squares of very large or small components leave the range of a double.
  const double largest = normal.cwiseAbs().maxCoeff();
  require(normal.allFinite() && largest > 0, "make_point: expected a finite normal that is not zero");
  ObstacleShape point;
  point.kind = ObstacleShape::Kind::Point;
  point.vertices = {Vec3::Zero()};
  point.corners = {{Vec3::Zero(), {(normal / largest).normalized()}}};
  return point;
}

ObstacleShape make_wire(const std::vector<Vec3>& points) {
  require(points.size() >= 2, "make_wire: expected two points or more");
  ObstacleShape wire;
  wire.kind = ObstacleShape::Kind::Wire;
  const bool closed = points.size() > 3 && points.front() == points.back();
  wire.vertices.assign(points.begin(), points.end() - (closed ? 1 : 0));
  const int n = static_cast<int>(wire.vertices.size()), n_edges = static_cast<int>(points.size()) - 1;
  const int first_joint = closed ? 0 : 1, n_joints = closed ? n : n - 2;
  for (int j = 0; j < n_joints; ++j) wire.corners.push_back({points[static_cast<std::size_t>(first_joint + j)], {}});
  const auto joint_at = [&](int point) {
    const int joint = (closed ? point % n : point) - first_joint;
    return joint >= 0 && joint < n_joints ? joint : -1;
  };
  for (int k = 0; k < n_edges; ++k) {
    SharpEdge edge;
    edge.a = points[static_cast<std::size_t>(k)];
    edge.b = points[static_cast<std::size_t>(k + 1)];
    const double length = (edge.b - edge.a).norm();
    require(std::isfinite(length) && length > 0, "make_wire: expected finite points, each unlike the one before it");
    edge.corners = {joint_at(k), joint_at(k + 1)};
    edge.free_cone = true;
    wire.edges.push_back(edge);
  }
  return wire;
}

Pose pose_at(const Obstacle& obstacle, double time) {
  require(std::isfinite(time) && time >= 0, "pose_at: expected a finite time >= 0");
  const auto& motion = obstacle.motion;
  require(std::is_sorted(motion.begin(), motion.end(), [](const auto& a, const auto& b) { return a.time < b.time; }),
          "pose_at: expected motion keys with ascending times");
  Pose pose = obstacle.start;
  pose.velocity = Vec3::Zero();
  pose.spin = Mat3::Zero();
  for (std::size_t k = 0; k < motion.size() && motion[k].time <= time; ++k) {
    const double next = k + 1 < motion.size() ? motion[k + 1].time : std::numeric_limits<double>::infinity();
    const double from = std::max(motion[k].time, 0.0), to = std::min(next, time);
    if (to > from) move(pose, motion[k], to - from);
    pose.velocity = motion[k].velocity;
    pose.spin = cross_matrix(motion[k].angular_velocity);
  }
  return pose;
}

std::optional<double> signed_distance(const ObstacleShape& shape, const Pose& pose, const Vec3& p) {
  switch (shape.kind) {
    case ObstacleShape::Kind::Box:
      return box_signed_distance(shape.half_size, pose.to_local(p));
    case ObstacleShape::Kind::Point:
    case ObstacleShape::Kind::Wire:
      return std::nullopt;
    case ObstacleShape::Kind::Mesh:
      require(shape.surface != nullptr, "signed_distance: expected a mesh made by make_mesh");
      return shape.surface->nearest(pose.to_local(p)).distance;
  }
  return std::nullopt;
}

}  // namespace crease
