// SPDX-License-Identifier: MIT
#include "crease/geometry/wire.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "crease/geometry/normal_cone.hpp"
#include "crease/geometry/triangle.hpp"

namespace crease {
namespace {

/// Up to here the normals of a fold's two sides say what is outside, also for a sheet that is bent away from the wire.
/// Beyond, 135 degrees, they nearly cancel, and only a fold round the wire can be as sharp: cosine of half the angle.
constexpr double sharp_fold = 0.38;

struct FoldSides {
  Vec3 normal = Vec3::Zero();   ///< mean of the two sides' normals, |.| = cos(fold / 2)
  Vec3 outward = Vec3::Zero();  ///< minus the mean of the ways from the fold into the sides, |.| = sin(fold / 2)
};

/// Every face counts by its corner angle at the vertex, so that the two sides of a fold weigh the same.
FoldSides fold_sides(const Mesh& mesh, int vertex, const Vec3& tangent) {
  FoldSides sum;
  double whole = 0;
  const Vec3& x = mesh.x[static_cast<std::size_t>(vertex)];
  for (const int h : mesh.outgoing(vertex)) {
    const Vec3 p = mesh.x[static_cast<std::size_t>(mesh.to(h))] - x;
    const Vec3 q = mesh.x[static_cast<std::size_t>(mesh.opposite(h))] - x;
    const Vec3 area = p.cross(q);
    const double angle = std::atan2(area.norm(), p.dot(q));
    if (!(area.norm() > 0)) continue;
    const Vec3 normal = area.normalized();
    const Vec3 across = normal.cross(tangent);
    sum.normal += angle * normal;
    sum.outward -= std::copysign(angle, across.dot(p + q)) * across;
    whole += angle;
  }
  if (whole > 0) sum.normal /= whole, sum.outward /= whole;
  return sum;
}

Vec3 unit_across(const Vec3& direction, const Vec3& tangent) {
  const Vec3 across = direction - direction.dot(tangent) * tangent;
  const double length = across.norm();
  constexpr double lost = 1e-9;
  return length > lost ? Vec3(across / length) : Vec3(Vec3::Zero());
}

int side_of_neighbours(const Cloth& cloth, int vertex) {
  const Mesh& mesh = cloth.mesh;
  for (const int u : mesh.neighbours(vertex)) {
    const FeatureId& other = cloth.feature[static_cast<std::size_t>(u)];
    if (other.side != 0 && other.obstacle == cloth.feature[static_cast<std::size_t>(vertex)].obstacle &&
        mesh.tag(mesh.find_edge(vertex, u)) != 0)
      return other.side;
  }
  return 0;
}

int side_of_gap(const Cloth& cloth, int vertex, const PosedObstacle& obstacle) {
  const FeatureId& id = cloth.feature[static_cast<std::size_t>(vertex)];
  const ObstacleShape& shape = *obstacle.shape;
  const auto index = static_cast<std::size_t>(id.index);
  const bool is_edge = id.kind == FeatureKind::Edge;
  const Vec3 tangent = is_edge
                           ? Vec3(obstacle.pose.rotation * (shape.edges[index].b - shape.edges[index].a).normalized())
                           : Vec3(Vec3::Zero());
  const Vec3 place = obstacle.pose.to_world(is_edge ? shape.edges[index].a : shape.corners[index].position);
  const double gap =
      fold_sides(cloth.mesh, vertex, tangent).normal.dot(cloth.mesh.x[static_cast<std::size_t>(vertex)] - place);
  return gap > 0 ? 1 : gap < 0 ? -1 : 0;
}

}  // namespace

bool is_on_wire(const FeatureId& feature, const ObstacleShape& shape) {
  const auto index = static_cast<std::size_t>(feature.index);
  if (feature.kind == FeatureKind::Edge) return shape.edges[index].free_cone;
  return feature.kind == FeatureKind::Corner && shape.corners[index].normals.empty();
}

Vec3 wire_normal(const Cloth& cloth, int vertex, const Vec3& tangent) {
  const int side = cloth.feature[static_cast<std::size_t>(vertex)].side;
  if (side == 0) return Vec3::Zero();
  const FoldSides fold = fold_sides(cloth.mesh, vertex, tangent);
  const Vec3 normal = side * fold.normal;
  if (fold.outward.norm() <= fold.normal.norm()) return unit_across(normal, tangent);
  const bool bent_away = fold.normal.norm() > sharp_fold && normal.dot(fold.outward) < 0;
  return unit_across(bent_away ? Vec3(-fold.outward) : fold.outward, tangent);
}

Vec3 support_normal(const Cloth& cloth, int vertex, const Vec3& tangent, std::span<const Vec3> normals) {
  const FoldSides fold = fold_sides(cloth.mesh, vertex, tangent);
  Vec3 mean = mean_normal(normals);
  const Vec3 normal = unit_across(fold.outward.norm() <= fold.normal.norm() ? fold.normal : fold.outward, tangent);
  if (normal.isZero()) return mean;
  return nearest_in_cone(normals, normal.dot(mean) < 0 ? Vec3(-normal) : normal);
}

void spread_wire_sides(Cloth& cloth, std::span<const PosedObstacle> obstacles) {
  std::vector<int> unknown;
  for (int v = 0; v < cloth.mesh.vertex_slots(); ++v) {
    const FeatureId& id = cloth.feature[static_cast<std::size_t>(v)];
    if (id.kind == FeatureKind::None || id.side != 0) continue;
    if (is_on_wire(id, *obstacles[static_cast<std::size_t>(id.obstacle)].shape)) unknown.push_back(v);
  }
  for (std::size_t before = unknown.size() + 1; unknown.size() < before;) {
    before = unknown.size();
    std::erase_if(unknown, [&](int v) {
      FeatureId& id = cloth.feature[static_cast<std::size_t>(v)];
      id.side = side_of_neighbours(cloth, v);
      return id.side != 0;
    });
  }
  for (const int v : unknown) {
    FeatureId& id = cloth.feature[static_cast<std::size_t>(v)];
    id.side = side_of_gap(cloth, v, obstacles[static_cast<std::size_t>(id.obstacle)]);
  }
}

}  // namespace crease
