// SPDX-License-Identifier: MIT
#include "crease/geometry/chain.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "crease/base/require.hpp"
#include "crease/geometry/feature_place.hpp"
#include "crease/geometry/triangle.hpp"

namespace crease {
namespace {

/// World tangent of the obstacle edge that a vertex rides on, a -> b.
Vec3 edge_tangent(const FeatureId& feature, std::span<const PosedObstacle> obstacles) {
  const PosedObstacle& posed = obstacles[static_cast<std::size_t>(feature.obstacle)];
  const SharpEdge& edge = posed.shape->edges[static_cast<std::size_t>(feature.index)];
  return posed.pose.rotation * (edge.b - edge.a).normalized();
}

/// Material direction whose image is nearest to the world direction d, in the mean of the vertex's faces: by the face,
/// since on a sharp fold the mean of their F is not that of a surface any more, and across the fold nearly zero.
Vec2 pull_back(const Mesh& mesh, int vertex, const Vec3& d) {
  Vec2 sum = Vec2::Zero(), steepest = Vec2::Zero();
  for (const int h : mesh.outgoing(vertex)) {
    const int f = Mesh::face_of(h);
    const Mat32 F = deformation_gradient(mesh, f);
    const Mat2 C = F.transpose() * F;
    const Vec2 right = mesh.material_area(f) * F.transpose() * d;
    if (C.determinant() > 0) sum += C.inverse() * right;
    steepest += right;
  }
  if (sum.norm() > 0) return sum.normalized();
  return steepest.norm() > 0 ? Vec2(steepest.normalized()) : Vec2(1, 0);
}

}  // namespace

std::vector<int> chain_edges(const Cloth& cloth, int vertex, int tag) {
  std::vector<int> edges;
  for (const int i : cloth.mesh.neighbours(vertex)) {
    const int h = cloth.mesh.find_edge(vertex, i);
    if (cloth.mesh.tag(h) == tag) edges.push_back(h);
  }
  return edges;
}

Vec2 chain_tangent(const Cloth& cloth, int vertex, std::span<const PosedObstacle> obstacles) {
  const FeatureId& feature = cloth.feature[vertex];
  require(feature.kind == FeatureKind::Edge, "chain_tangent: expected a vertex that is EOL on an edge");
  const Mesh& mesh = cloth.mesh;
  const Vec3 along = edge_tangent(feature, obstacles);
  Vec2 sum = Vec2::Zero();
  for (const int h : chain_edges(cloth, vertex, edge_tag(feature.obstacle, feature.index))) {
    const Vec2 direction = (mesh.X[mesh.to(h)] - mesh.X[mesh.from(h)]).normalized();
    sum += (mesh.x[mesh.to(h)] - mesh.x[mesh.from(h)]).dot(along) < 0 ? Vec2(-direction) : direction;
  }
  // Two directions that nearly cancel (a hairpin in material space) say nothing; the deformation still does.
  constexpr double cancelled = 1e-6;
  if (sum.norm() > cancelled) return sum.normalized();
  return pull_back(mesh, vertex, along);
}

double fold_angle(const Cloth& cloth, int vertex) {
  const Mesh& mesh = cloth.mesh;
  double angle = 0;
  for (const int u : mesh.neighbours(vertex)) {
    const int h = mesh.find_edge(vertex, u);
    if (mesh.tag(h) == 0 || mesh.is_border(h)) continue;
    const Vec3 m = face_normal(mesh, Mesh::face_of(h)), n = face_normal(mesh, Mesh::face_of(mesh.twin(h)));
    angle = std::max(angle, std::atan2(m.cross(n).norm(), m.dot(n)));
  }
  return angle;
}

std::vector<LeftStretch> stretches_at(const Cloth& cloth, int vertex, std::span<const PosedObstacle> obstacles) {
  const Mesh& mesh = cloth.mesh;
  std::vector<LeftStretch> stretches;
  if (cloth.feature[vertex].kind == FeatureKind::Corner) stretches.push_back({.feature = cloth.feature[vertex]});
  for (const int u : mesh.neighbours(vertex)) {
    const int tag = mesh.tag(mesh.find_edge(vertex, u));
    if (tag == 0) continue;
    const WorldEdge edge = world_edge(tag_feature(tag), obstacles);
    const auto [from, to] = std::minmax({edge.parameter(mesh.x[vertex]), edge.parameter(mesh.x[u])});
    stretches.push_back({.feature = tag_feature(tag), .from = from, .to = to});
  }
  return stretches;
}

bool was_left(const Cloth& cloth, const FeatureId& feature, double at) {
  return std::any_of(cloth.left.begin(), cloth.left.end(), [&](const LeftStretch& left) {
    return left.feature == feature && (feature.kind == FeatureKind::Corner || (left.from <= at && at <= left.to));
  });
}

bool was_left_between(const Cloth& cloth, const FeatureId& edge, double from, double to, double share) {
  return std::any_of(cloth.left.begin(), cloth.left.end(), [&](const LeftStretch& left) {
    return left.feature == edge && std::min(left.to, to) - std::max(left.from, from) > share;
  });
}

Vec2 border_normal(const Mesh& mesh, int vertex) {
  require(mesh.is_border_vertex(vertex), "border_normal: expected a border vertex");
  const auto around = mesh.neighbours(vertex);
  const Vec2 in = (mesh.X[vertex] - mesh.X[around.back()]).normalized();
  const Vec2 out = (mesh.X[around.front()] - mesh.X[vertex]).normalized();
  const Vec2 tangent = in + out;
  const Vec2 t = tangent.norm() > 0 ? Vec2(tangent.normalized()) : out;
  return {t.y(), -t.x()};  // outward: the material is on the left of its border
}

std::vector<Vec2> eulerian_rows(const Cloth& cloth, int vertex, std::span<const PosedObstacle> obstacles) {
  if (!cloth.is_eol(vertex)) return {};
  if (cloth.mesh.is_border_vertex(vertex)) return {border_normal(cloth.mesh, vertex)};
  if (cloth.feature[vertex].kind == FeatureKind::Edge) return {chain_tangent(cloth, vertex, obstacles)};
  return {};
}

}  // namespace crease
