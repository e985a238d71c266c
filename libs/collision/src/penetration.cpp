// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include <Eigen/Geometry>

#include "crease/base/require.hpp"
#include "crease/collision/detect.hpp"

namespace crease {
namespace {

// Barycentric weights of the points of a lattice of `level` subdivisions: (level + 1) (level + 2) / 2 of them.
std::vector<Vec3> lattice(int level) {
  std::vector<Vec3> weights;
  for (int i = 0; i <= level; ++i) {
    for (int j = 0; i + j <= level; ++j) weights.push_back(Vec3(level - i - j, i, j) / level);
  }
  return weights;
}

// Bounds in the obstacle's own frame, where a box is tight.
Eigen::AlignedBox3d local_bounds(const ObstacleShape& shape) {
  Eigen::AlignedBox3d bounds;
  for (const Vec3& p : shape.vertices) bounds.extend(p);
  return bounds;
}

double depth_in(const Cloth& cloth, const PosedObstacle& obstacle, std::span<const Vec3> weights) {
  const Mesh& mesh = cloth.mesh;
  const Eigen::AlignedBox3d bounds = local_bounds(*obstacle.shape);
  const Pose in_place;  // points are in the obstacle's frame already
  const ClosedSurface* surface = obstacle.shape->surface.get();
  int last = -1;  // triangle nearest to the point before
  double depth = 0;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face_live(f)) continue;
    std::array<Vec3, 3> x;
    Eigen::AlignedBox3d face;
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = obstacle.pose.to_local(mesh.x[static_cast<std::size_t>(mesh.face(f)[k])]);
      face.extend(x[k]);
    }
    if (!face.intersects(bounds)) continue;
    for (const Vec3& w : weights) {
      const Vec3 p = w[0] * x[0] + w[1] * x[1] + w[2] * x[2];
      if (surface != nullptr) {
        const SurfaceFoot foot = surface->nearest(p, last);
        last = foot.triangle;
        depth = std::max(depth, -foot.distance);
      } else if (const auto distance = signed_distance(*obstacle.shape, in_place, p)) {
        depth = std::max(depth, -*distance);
      }
    }
  }
  return depth;
}

}  // namespace

double max_penetration(const Cloth& cloth, std::span<const PosedObstacle> obstacles, int level) {
  require(level >= 1, "max_penetration: expected at least one subdivision");
  const std::vector<Vec3> weights = lattice(level);
  double depth = 0;
  for (const PosedObstacle& obstacle : obstacles) {
    require(obstacle.shape != nullptr, "max_penetration: expected obstacles with a shape");
    if (!obstacle.shape->triangles.empty()) depth = std::max(depth, depth_in(cloth, obstacle, weights));
  }
  return depth;
}

}  // namespace crease
