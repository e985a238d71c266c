// SPDX-License-Identifier: MIT
#include "surface.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Geometry>

#include "crease/base/require.hpp"
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
  for (int k = 0; k < 3; ++k)
    if (excess[k] >= -rim_tolerance) found.rim_normals.push_back(sign_of(p[k]) * Vec3::Unit(k));
  if (found.rim_normals.size() < 2) found.rim_normals.clear();
  if (!found.rim_normals.empty()) found.normal = mean_normal(found.rim_normals);
  return found;
}

SurfacePoint nearest_on_box(const Vec3& half_size, const Vec3& p) {
  const bool outside = (p.cwiseAbs() - half_size).cwiseMax(0.0).norm() > rim_tolerance;
  return outside ? from_outside(half_size, p) : from_inside(half_size, p);
}

double distance_to_side(const TriangleSurface& mesh, const std::array<int, 3>& corners, std::size_t k, const Vec3& p) {
  const Vec3& a = mesh.vertices[corners[k]];
  const Vec3 e = mesh.vertices[corners[(k + 1) % 3]] - a;
  return e.cross(p - a).norm() / e.norm();
}

// Normals of the sharp corner, or else of the sharp edge, that a foot on the surface lies on.
std::span<const Vec3> rim_of_mesh(const ObstacleShape& shape, const SurfaceFoot& foot) {
  const TriangleSurface& mesh = shape.surface->mesh();
  const auto& corners = mesh.triangles[foot.triangle];
  const auto edge_near = [&](int triangle) {
    for (std::size_t k = 0; k < 3; ++k)
      if (const int e = shape.edge_at[triangle][k];
          e >= 0 && distance_to_side(mesh, mesh.triangles[triangle], k, foot.point) <= rim_tolerance)
        return e;
    return -1;
  };
  int edge = edge_near(foot.triangle);
  for (const int i : corners) {
    if ((mesh.vertices[i] - foot.point).norm() > rim_tolerance) continue;
    if (shape.corner_at[i] >= 0) return shape.corners[shape.corner_at[i]].normals;
    for (const int t : shape.surface->triangles_at(i)) edge = edge >= 0 ? edge : edge_near(t);
  }
  if (edge < 0) return {};
  return shape.edges[edge].normals;
}

SurfacePoint on_mesh(const ObstacleShape& shape, const Vec3& p, const SurfaceFoot& foot) {
  SurfacePoint found{foot.point, foot.normal, foot.distance};
  const bool on_face = foot.edge < 0 && foot.corner < 0;
  if (std::abs(foot.distance) <= rim_tolerance) {
    const auto rim = rim_of_mesh(shape, foot);
    found.rim_normals.assign(rim.begin(), rim.end());
    if (!rim.empty()) found.normal = mean_normal(rim);
  } else if (!on_face) {
    found.normal = (p - foot.point) / foot.distance;
  }
  return found;
}

bool touches(const ObstacleShape& shape, const SurfaceFoot& foot, std::span<const int> patches) {
  const auto is_one = [&](int triangle) {
    return std::find(patches.begin(), patches.end(), shape.patch[triangle]) != patches.end();
  };
  if (is_one(foot.triangle)) return true;
  if (foot.edge >= 0) return is_one(shape.surface->across(foot.triangle, foot.edge));
  if (foot.corner < 0) return false;
  const auto& around = shape.surface->triangles_at(shape.surface->mesh().triangles[foot.triangle][foot.corner]);
  return std::any_of(around.begin(), around.end(), is_one);
}

std::span<const int> patches_of(const ObstacleShape& shape, const FeatureId& feature) {
  if (feature.kind == FeatureKind::Edge) return shape.edges[feature.index].patches;
  if (feature.kind == FeatureKind::Corner) return shape.corners[feature.index].patches;
  return {};
}

void place(SurfacePoint& found, const Pose& pose) {
  found.point = pose.to_world(found.point);
  found.normal = pose.rotation * found.normal;
  for (Vec3& n : found.rim_normals) n = pose.rotation * n;
}

}  // namespace

std::vector<SurfacePoint> near_on_surface(const PosedObstacle& obstacle, const Vec3& p, double reach,
                                          const FeatureId& own) {
  const ObstacleShape& shape = *obstacle.shape;
  if (shape.triangles.empty()) return {};
  const bool rides = own.kind != FeatureKind::None;
  const Vec3 local = obstacle.pose.to_local(p);
  std::vector<SurfacePoint> found;
  if (shape.kind == ObstacleShape::Kind::Box) {
    if (rides) return {};
    if (SurfacePoint nearest = nearest_on_box(shape.half_size, local); nearest.distance <= reach)
      found.push_back(std::move(nearest));
  } else {
    if (rides && shape.surface->is_convex()) return {};
    for (const SurfaceFoot& foot : shape.surface->minima(local, reach))
      if (!rides || !touches(shape, foot, patches_of(shape, own))) found.push_back(on_mesh(shape, local, foot));
  }
  for (SurfacePoint& point : found) place(point, obstacle.pose);
  return found;
}

SurfacePoint nearest_on_surface(const PosedObstacle& obstacle, const Vec3& p) {
  const ObstacleShape& shape = *obstacle.shape;
  CREASE_ASSERT(!shape.triangles.empty());
  const Vec3 local = obstacle.pose.to_local(p);
  SurfacePoint found = shape.kind == ObstacleShape::Kind::Box ? nearest_on_box(shape.half_size, local)
                                                              : on_mesh(shape, local, shape.surface->nearest(local));
  place(found, obstacle.pose);
  return found;
}

}  // namespace crease
