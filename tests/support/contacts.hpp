// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "crease/collision/contact.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/obstacle.hpp"
#include "crease/geometry/triangle.hpp"

/// Contacts of cloth with sharp features of boxes and points by trying every pair: an oracle for fast searches and a
/// source of contacts for what comes after them. Faces are not looked at.
namespace crease::support {

/// Share of a direction that may lie outside the cone of a feature's normals: the sine of 2 degrees.
inline constexpr double cone_slack = 0.035;

inline bool rides_on(const FeatureId& vertex, const FeatureId& edge, const SharpEdge& shape) {
  if (vertex == edge) return true;
  return vertex.kind == FeatureKind::Corner && vertex.obstacle == edge.obstacle &&
         (vertex.index == shape.corners[0] || vertex.index == shape.corners[1]);
}

/// Cloth edges across one sharp edge between two orthogonal faces.
inline void edge_contacts(const Cloth& cloth, const PosedObstacle& obstacle, const FeatureId& feature, double reach,
                          std::vector<Contact>& contacts) {
  const SharpEdge& edge = obstacle.shape->edges[feature.index];
  const Vec3 a = obstacle.pose.to_world(edge.a), b = obstacle.pose.to_world(edge.b);
  const Vec3 n1 = obstacle.pose.rotation * edge.normals[0], n2 = obstacle.pose.rotation * edge.normals[1];
  const Vec3 tangent = (b - a).normalized();
  for (const int h : cloth.mesh.edges()) {
    const int p = cloth.mesh.from(h), q = cloth.mesh.to(h);
    if (rides_on(cloth.feature[p], feature, edge) || rides_on(cloth.feature[q], feature, edge)) continue;
    // Seen along the obstacle's edge: a segment against the origin.
    const Vec3 xp = cloth.mesh.x[p] - a, xq = cloth.mesh.x[q] - a;
    const Vec3 from = xp - xp.dot(tangent) * tangent, way = xq - xq.dot(tangent) * tangent - from;
    if (way.norm() < cone_slack * (xq - xp).norm()) continue;
    const double s = -from.dot(way) / way.squaredNorm();
    if (s < -1e-9 || s > 1 + 1e-9) continue;
    const double along = (1 - s) * xp.dot(tangent) + s * xq.dot(tangent);
    if (along < 0 || along > (b - a).norm()) continue;
    Vec3 normal = tangent.cross(way).normalized();
    if (normal.dot(n1 + n2) < 0) normal = -normal;
    if (normal.dot(n1) < -cone_slack || normal.dot(n2) < -cone_slack) continue;
    const double distance = from.dot(normal);
    if (std::abs(distance) > reach) continue;
    Contact contact;
    contact.type = ContactType::EdgeEdge;
    contact.obstacle = feature.obstacle;
    contact.feature = feature;
    contact.n_vertices = 2;
    contact.vertices = {p, q, -1};
    contact.weights = {1 - s, s, 0};
    contact.halfedge = h;
    contact.point = a + along * tangent;
    contact.normal = normal;
    contact.distance = distance;
    contact.velocity = obstacle.pose.velocity_at(contact.point);
    contacts.push_back(contact);
  }
}

/// Cloth faces over one sharp corner.
inline void corner_contacts(const Cloth& cloth, const PosedObstacle& obstacle, const FeatureId& feature, double reach,
                            std::vector<Contact>& contacts) {
  const SharpCorner& corner = obstacle.shape->corners[feature.index];
  const Vec3 tip = obstacle.pose.to_world(corner.position);
  for (int f = 0; f < cloth.mesh.face_slots(); ++f) {
    const std::array<int, 3> face = cloth.mesh.face(f);
    if (std::any_of(face.begin(), face.end(), [&](int v) { return cloth.feature[v] == feature; })) continue;
    const auto x = world_corners(cloth.mesh, f);
    Vec3 normal = face_normal(cloth.mesh, f), mean = Vec3::Zero();
    for (const Vec3& n : corner.normals) mean += obstacle.pose.rotation * n;
    if (normal.dot(mean) < 0) normal = -normal;
    bool in_cone = true;
    for (const Vec3& n : corner.normals) in_cone = in_cone && normal.dot(obstacle.pose.rotation * n) > -cone_slack;
    const double distance = normal.dot(x[0] - tip);
    if (!in_cone || std::abs(distance) > reach) continue;
    Mat3 basis;
    basis << x[1] - x[0], x[2] - x[0], normal;
    const Vec3 foot = basis.inverse() * (tip - x[0]);
    const Vec3 weights(1 - foot[0] - foot[1], foot[0], foot[1]);
    if (weights.minCoeff() < -1e-9) continue;
    Contact contact;
    contact.type = ContactType::CornerFace;
    contact.obstacle = feature.obstacle;
    contact.feature = feature;
    contact.n_vertices = 3;
    contact.vertices = face;
    contact.weights = {weights[0], weights[1], weights[2]};
    contact.face = f;
    contact.point = tip;
    contact.normal = normal;
    contact.distance = distance;
    contact.velocity = obstacle.pose.velocity_at(tip);
    contacts.push_back(contact);
  }
}

inline std::vector<Contact> feature_contacts(const Cloth& cloth, std::span<const PosedObstacle> obstacles,
                                             double reach) {
  std::vector<Contact> contacts;
  for (int o = 0; o < static_cast<int>(obstacles.size()); ++o) {
    const ObstacleShape& shape = *obstacles[o].shape;
    for (int e = 0; e < static_cast<int>(shape.edges.size()); ++e)
      edge_contacts(cloth, obstacles[o], {o, FeatureKind::Edge, e}, reach, contacts);
    for (int k = 0; k < static_cast<int>(shape.corners.size()); ++k)
      corner_contacts(cloth, obstacles[o], {o, FeatureKind::Corner, k}, reach, contacts);
  }
  return contacts;
}

}  // namespace crease::support
