// SPDX-License-Identifier: MIT
#include "crease/geometry/cloth.hpp"

#include <algorithm>
#include <cmath>

#include "crease/base/require.hpp"
#include "crease/geometry/feature_place.hpp"
#include "crease/geometry/triangle.hpp"

namespace crease {
namespace {

/// Edges of one obstacle that a tag can tell apart; leaves room for 2047 obstacles in an int.
constexpr int edges_per_obstacle = 1 << 20;
constexpr int max_obstacles = (1 << 11) - 1;

bool lies_on(const FeatureId& vertex, const FeatureId& edge) {
  if (vertex.obstacle != edge.obstacle) return false;
  // Which edges end at a corner is the obstacle's business; here any corner of the same obstacle may end a chain.
  return vertex.kind == FeatureKind::Corner || (vertex.kind == FeatureKind::Edge && vertex.index == edge.index);
}

bool is_age(double seconds) {
  return std::isfinite(seconds) && seconds >= 0;
}

std::optional<std::string> left_trouble(const LeftStretch& left) {
  if (left.feature.kind != FeatureKind::Edge && left.feature.kind != FeatureKind::Corner)
    return "what was left is no feature";
  if (left.feature.obstacle < 0 || left.feature.index < 0) return "what was left is a feature without a number";
  if (!is_age(left.age)) return "what was left was so at no time";
  if (!std::isfinite(left.from) || !std::isfinite(left.to) || left.from > left.to) return "what was left is no stretch";
  return std::nullopt;
}

std::optional<std::string> vertex_trouble(const Cloth& cloth, int i) {
  const std::string name = "vertex " + std::to_string(i);
  if (!cloth.v[i].allFinite() || !cloth.V[i].allFinite()) return name + " has a velocity that is not finite";
  if (const int u = cloth.mesh.tied(i); u != i) {
    if (cloth.v[i] != cloth.v[u] || cloth.pins[i] != cloth.pins[u])
      return name + " moves or is held otherwise than what it is tied to";
    if (cloth.is_eol(i)) return name + " is EOL but on a seam";
  }
  const FeatureId& feature = cloth.feature[i];
  if (!is_age(feature.away)) return name + " has lingered for no time";
  if (feature.away > 0 && !feature.lifted) return name + " lingers but is not lifted";
  if (!cloth.is_eol(i)) {
    if (feature.lifted) return name + " is lifted but not EOL";
    if (!cloth.V[i].isZero(0)) return name + " is Lagrangian but has an Eulerian velocity";
    return std::nullopt;
  }
  if (feature.kind != FeatureKind::Edge && feature.kind != FeatureKind::Corner)
    return name + " is EOL on no kind of feature";
  if (feature.obstacle < 0 || feature.index < 0) return name + " is EOL on a feature without a number";
  if (cloth.mesh.is_material_corner(i)) return name + " is EOL but a material corner";
  return std::nullopt;
}

}  // namespace

int Cloth::n_eol() const {
  int n = 0;
  for (int i = 0; i < mesh.vertex_slots(); ++i) n += mesh.vertex_live(i) && is_eol(i) ? 1 : 0;
  return n;
}

Vec3 Cloth::world_velocity(int vertex) const {
  if (!is_eol(vertex)) return v[vertex];
  return v[vertex] - vertex_deformation_gradient(mesh, vertex) * V[vertex];
}

Cloth make_cloth(Mesh mesh) {
  const auto n = static_cast<std::size_t>(mesh.vertex_slots());
  Cloth cloth;
  cloth.mesh = std::move(mesh);
  cloth.v.assign(n, Vec3::Zero());
  cloth.V.assign(n, Vec2::Zero());
  cloth.feature.assign(n, FeatureId{});
  cloth.pins.assign(n, 0);
  return cloth;
}

void make_lagrangian(Cloth& cloth, int vertex) {
  cloth.v[vertex] = cloth.world_velocity(vertex);
  cloth.V[vertex].setZero();
  cloth.feature[vertex] = {};
  for (const int i : cloth.mesh.neighbours(vertex)) cloth.mesh.set_tag(cloth.mesh.find_edge(vertex, i), 0);
}

int edge_tag(int obstacle, int index) {
  require(obstacle >= 0 && obstacle < max_obstacles, "edge_tag: obstacle number out of range");
  require(index >= 0 && index < edges_per_obstacle, "edge_tag: edge number out of range");
  return 1 + obstacle * edges_per_obstacle + index;
}

FeatureId tag_feature(int tag) {
  require(tag > 0, "tag_feature: expected a tag made by edge_tag, got " + std::to_string(tag));
  return {(tag - 1) / edges_per_obstacle, FeatureKind::Edge, (tag - 1) % edges_per_obstacle};
}

std::optional<std::string> validate(const Cloth& cloth) {
  const Mesh& mesh = cloth.mesh;
  if (auto trouble = mesh.validate()) return trouble;
  const auto n = mesh.X.size();
  if (cloth.v.size() != n || cloth.V.size() != n || cloth.feature.size() != n || cloth.pins.size() != n) {
    return "cloth arrays and vertex slots differ in number";
  }
  for (int i = 0; i < mesh.vertex_slots(); ++i) {
    if (!mesh.vertex_live(i)) continue;
    if (auto trouble = vertex_trouble(cloth, i)) return trouble;
  }
  for (const int h : mesh.edges()) {
    const int tag = mesh.tag(h);
    if (tag == 0) continue;
    const std::string name = "edge " + std::to_string(mesh.from(h)) + "-" + std::to_string(mesh.to(h));
    if (tag < 0) return name + " carries a tag that names no feature";
    for (const int i : {mesh.from(h), mesh.to(h)}) {
      if (!lies_on(cloth.feature[i], tag_feature(tag)))
        return name + " is tagged with a feature that one end is not on";
    }
  }
  for (const LeftStretch& left : cloth.left)
    if (auto trouble = left_trouble(left)) return trouble;
  return std::nullopt;
}

std::optional<std::string> validate(const Cloth& cloth, std::span<const PosedObstacle> obstacles, double longest) {
  if (auto trouble = validate(cloth)) return trouble;
  const Mesh& mesh = cloth.mesh;
  for (int i = 0; i < mesh.vertex_slots(); ++i) {
    if (!mesh.vertex_live(i) || !cloth.is_eol(i)) continue;
    const std::string name = "vertex " + std::to_string(i);
    if (!exists(cloth.feature[i], obstacles)) return name + " is EOL on a feature that no obstacle has";
    if (cloth.feature[i].away > longest) return name + " has lingered for too long";
  }
  for (const int h : mesh.edges()) {
    if (mesh.tag(h) == 0) continue;
    const FeatureId edge = tag_feature(mesh.tag(h));
    if (!exists(edge, obstacles) || !lies_on(cloth.feature[mesh.from(h)], edge, obstacles) ||
        !lies_on(cloth.feature[mesh.to(h)], edge, obstacles))
      return "edge " + std::to_string(mesh.from(h)) + "-" + std::to_string(mesh.to(h)) +
             " is tagged with a feature that one end is not on";
  }
  for (const LeftStretch& left : cloth.left) {
    if (!exists(left.feature, obstacles)) return "what was left is a feature that no obstacle has";
    if (left.age > longest) return "what was left was so too long ago";
  }
  return std::nullopt;
}

}  // namespace crease
