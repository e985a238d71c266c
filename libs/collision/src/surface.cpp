// SPDX-License-Identifier: MIT
#include "surface.hpp"

#include <span>

#include "crease/geometry/normal_cone.hpp"

namespace crease {
namespace {

double sign_of(double value) {
  return value < 0 ? -1.0 : 1.0;
}

// Beyond the rim of a face the direction from the rim; it lies in the cone of the rim's normals by construction.
SurfacePoint from_outside(const Vec3& half_size, const Vec3& p) {
  SurfacePoint found;
  found.point = p.cwiseMax(-half_size).cwiseMin(half_size);
  found.distance = (p - found.point).norm();
  found.normal = (p - found.point) / found.distance;
  return found;
}

// Inside, or on the surface up to rim_tolerance: the face of least depth, the lowest axis among equals.
SurfacePoint from_inside(const Vec3& half_size, const Vec3& p) {
  const Vec3 excess = p.cwiseAbs() - half_size;
  int axis = 0;
  SurfacePoint found;
  found.distance = excess.maxCoeff(&axis);
  found.point = p;
  found.point[axis] = sign_of(p[axis]) * half_size[axis];
  found.normal = sign_of(p[axis]) * Vec3::Unit(axis);
  for (int k = 0; k < 3; ++k) {
    if (excess[k] >= -rim_tolerance) found.rim_normals[found.n_rim++] = sign_of(p[k]) * Vec3::Unit(k);
  }
  if (found.n_rim < 2) found.n_rim = 0;
  if (found.n_rim > 0) found.normal = mean_normal(std::span(found.rim_normals.data(), found.n_rim));
  return found;
}

SurfacePoint nearest_on_box(const Vec3& half_size, const Vec3& p) {
  const bool outside = (p.cwiseAbs() - half_size).cwiseMax(0.0).norm() > rim_tolerance;
  return outside ? from_outside(half_size, p) : from_inside(half_size, p);
}

}  // namespace

std::optional<SurfacePoint> nearest_on_surface(const PosedObstacle& obstacle, const Vec3& p) {
  if (obstacle.shape->kind != ObstacleShape::Kind::Box) return std::nullopt;
  const Pose& pose = obstacle.pose;
  SurfacePoint found = nearest_on_box(obstacle.shape->half_size, pose.to_local(p));
  found.point = pose.to_world(found.point);
  found.normal = pose.rotation * found.normal;
  for (int k = 0; k < found.n_rim; ++k) found.rim_normals[k] = pose.rotation * found.rim_normals[k];
  return found;
}

}  // namespace crease
