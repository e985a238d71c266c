// SPDX-License-Identifier: MIT
#include "narrow_phase.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "crease/geometry/normal_cone.hpp"
#include "crease/geometry/triangle.hpp"
#include "surface.hpp"

namespace crease {
namespace {

// Closest points count as inside a segment or face up to this fraction of it: round-off when a feature passes exactly
// through a cloth vertex, so that at least one of the edges or faces there reports it.
constexpr double interval_slack = 1e-9;

// Two edges nearer to parallel than this have no closest points worth the name: sine of 2 degrees.
constexpr double parallel_sine = 0.0349;

// |distance| against the way out by a face: the tolerated normal stands up to 2 degrees off the cone, and
// 1 / cos(2 degrees) = 1.0006; coordinates of a metre carry round-off far below 1e-9 m.
constexpr double way_out_slack = 1e-3, way_out_round_off = 1e-9;

// Barycentric coordinates of the foot of p on the plane of a triangle with positive area.
Vec3 foot_weights(const std::array<Vec3, 3>& x, const Vec3& p) {
  const Vec3 normal = (x[1] - x[0]).cross(x[2] - x[0]);
  const Vec3 weights(normal.dot((x[1] - p).cross(x[2] - p)), normal.dot((x[2] - p).cross(x[0] - p)),
                     normal.dot((x[0] - p).cross(x[1] - p)));
  return weights / normal.squaredNorm();
}

// The cloth on both sides of one of its edges.
struct Sheet {
  std::array<int, 4> vertices;  // the edge's, and those opposite; the last twice on the border
  Vec3 area = Vec3::Zero();     // sum of the faces' area vectors
};

Sheet sheet_beside(const Mesh& mesh, int halfedge) {
  const int twin = mesh.twin(halfedge), other = twin == Mesh::none ? halfedge : twin;
  Sheet sheet{{mesh.from(halfedge), mesh.to(halfedge), mesh.opposite(halfedge), mesh.opposite(other)}};
  for (const int h : {halfedge, twin}) {
    if (h == Mesh::none) continue;
    const auto x = world_corners(mesh, Mesh::face_of(h));
    sheet.area += (x[1] - x[0]).cross(x[2] - x[0]);
  }
  return sheet;
}

// A wire is on the side of the sheet that is known from a vertex that rides on it, else touched from the side the cloth
// is on; from where it came if it is exactly there. Negative: `normal` points the wrong way.
double wire_side(const Vec3& normal, double distance, const Vec3& velocity, int known, const Vec3& sheet) {
  const double facing = normal.dot(sheet);
  if (known != 0 && facing != 0) return known * facing;
  return std::abs(distance) > rim_tolerance ? distance : -normal.dot(velocity);
}

}  // namespace

// The mesh moves with xdot, for an EOL vertex too; relative to the obstacle taken as a rigid frame.
Vec3 NarrowPhase::relative_velocity(int vertex) const {
  const auto i = static_cast<std::size_t>(vertex);
  return cloth_.v[i] - obstacle_.source.pose.velocity_at(cloth_.mesh.x[i]);
}

double NarrowPhase::reach(const Vec3& velocity) const {
  return options_.threshold + options_.margin + options_.look_ahead * velocity.norm();
}

bool NarrowPhase::on_feature(int vertex, FeatureKind kind, int index) const {
  return cloth_.rides(vertex) &&
         cloth_.feature[static_cast<std::size_t>(vertex)] == FeatureId{obstacle_.index, kind, index};
}

// On which side of the sheet the wire is, as the first of these vertices that rides on it knows; 0 if none does.
int NarrowPhase::side_of_sheet(std::span<const int> vertices) const {
  for (const int i : vertices) {
    const FeatureId& id = cloth_.feature[static_cast<std::size_t>(i)];
    if (id.side != 0 && id.obstacle == obstacle_.index) return id.side;
  }
  return 0;
}

Contact NarrowPhase::make_contact(ContactType type, const Vec3& point, const Vec3& normal, double distance) const {
  Contact contact;
  contact.type = type;
  contact.obstacle = obstacle_.index;
  contact.point = point;
  contact.normal = normal;
  contact.distance = distance;
  contact.velocity = obstacle_.source.pose.velocity_at(point);
  return contact;
}

// A vertex on the rim itself (see rim_tolerance) has no direction from it. Any normal of the cone keeps it out of the
// solid, since a n1 + b n2 with a, b >= 0 can only grow if one of the two does; both rows at once would lock the cloth
// (paper, Fig. 3a). The cloth's own normal, turned to the obstacle's outside and limited to the cone, is the one that
// pushes a flat sheet nowhere but off the face it lies on.
Vec3 NarrowPhase::rim_normal(int vertex, std::span<const Vec3> normals, const Vec3& mean) const {
  Vec3 sum = Vec3::Zero();  // area-weighted
  for (const int h : cloth_.mesh.outgoing(vertex)) {
    const auto x = world_corners(cloth_.mesh, Mesh::face_of(h));
    sum += (x[1] - x[0]).cross(x[2] - x[0]);
  }
  const double length = sum.norm(), side = sum.dot(mean);
  if (!(std::abs(side) > cone_tolerance * length)) return mean;  // upright or degenerate: the cloth has no say
  return nearest_in_cone(normals, (side < 0 ? -1.0 : 1.0) / length * sum);
}

std::vector<Contact> NarrowPhase::vertex_face(int vertex) const {
  const auto& feature = cloth_.feature[static_cast<std::size_t>(vertex)];
  const FeatureId own = feature.obstacle == obstacle_.index && cloth_.rides(vertex) ? feature : FeatureId{};
  const Vec3& x = cloth_.mesh.x[static_cast<std::size_t>(vertex)];
  std::vector<Contact> contacts;
  for (const SurfacePoint& near : near_on_surface(obstacle_.source, x, reach(relative_velocity(vertex)), own)) {
    const Vec3 normal = near.rim_normals.empty() ? near.normal : rim_normal(vertex, near.rim_normals, near.normal);
    Contact contact = make_contact(ContactType::VertexFace, near.point, normal, near.distance);
    contact.n_vertices = 1;
    contact.vertices[0] = vertex;
    contact.weights[0] = 1;
    contacts.push_back(contact);
  }
  return contacts;
}

// A gap has to be in reach, no more. A penetration has to be the way out of the solid: for no face may the piece of
// cloth have less far to go. Else that face, and the vertices inside, are what the cloth is in contact with. Without
// this rule
// - the far edge of a thin plate would pull down the cloth that lies on the plate and hangs over its side,
// - an upright edge of a box would push sideways a cloth that lies flat on the top, across the corner,
// - an edge would push aside a cloth that stands or stabs through the middle of a face.
// Shapes without a surface have no inside: far behind a tip is far. So it is on a solid that is not convex, or round:
// its planes alone do not tell which faces are a way out, so the feature's own are asked, and the one that is nearest
// to where the cloth is deepest.
bool NarrowPhase::is_way_out(const Pair& pair) const {
  if (pair.distance >= 0) return pair.distance <= pair.reach;
  if (obstacle_.faces.empty() && -pair.distance > pair.reach) return false;
  if (!obstacle_.has_surface) return true;
  const auto stays_in = [&](const FacePlane& face) {
    double depth = 0;
    for (const Vec3& p : pair.points) depth = std::max(depth, face.offset - face.normal.dot(p));
    const bool is_own =
        std::any_of(pair.own.begin(), pair.own.end(), [&](const Vec3& n) { return n.dot(face.normal) > 0.999; });
    const double slack = is_own ? own_face_slack * options_.threshold : 0.0;
    return -pair.distance <= (1 + way_out_slack) * depth + slack + way_out_round_off;
  };
  if (!obstacle_.faces.empty()) return std::all_of(obstacle_.faces.begin(), obstacle_.faces.end(), stays_in);
  const SurfacePoint nearest = nearest_on_surface(obstacle_.source, pair.on_cloth);
  std::vector<FacePlane> ways;
  if (nearest.distance < 0) ways.push_back({nearest.normal, nearest.normal.dot(nearest.point)});
  for (const Vec3& n : pair.own) ways.push_back({n, n.dot(pair.on_feature)});
  return std::all_of(ways.begin(), ways.end(), stays_in);
}

// Next to a vertex that rides on this obstacle its own rows keep the cloth out.
bool NarrowPhase::is_guarded_by_end(int halfedge, double s) const {
  const int end = s < 0.5 ? cloth_.mesh.from(halfedge) : cloth_.mesh.to(halfedge);
  const Vec3 along = cloth_.mesh.x[static_cast<std::size_t>(cloth_.mesh.to(halfedge))] -
                     cloth_.mesh.x[static_cast<std::size_t>(cloth_.mesh.from(halfedge))];
  return cloth_.rides(end) && cloth_.feature[static_cast<std::size_t>(end)].obstacle == obstacle_.index &&
         std::min(s, 1 - s) * along.norm() <= options_.threshold;
}

std::optional<Contact> NarrowPhase::edge_edge(int halfedge, const PlacedEdge& e, const FeatureId& id) const {
  const std::array<int, 2> ends{cloth_.mesh.from(halfedge), cloth_.mesh.to(halfedge)};
  const std::array<Vec3, 2> x{cloth_.mesh.x[static_cast<std::size_t>(ends[0])],
                              cloth_.mesh.x[static_cast<std::size_t>(ends[1])]};
  // Position along the obstacle's edge, and across it: the common normal is orthogonal to the edge, so that the closest
  // points are found in the plane across it, where the edge is the origin.
  const std::array<double, 2> along{(x[0] - e.a).dot(e.tangent), (x[1] - e.a).dot(e.tangent)};
  const double slack = interval_slack * e.length;
  if (std::max(along[0], along[1]) < -slack || std::min(along[0], along[1]) > e.length + slack) return std::nullopt;
  const Vec3 start = x[0] - e.a - along[0] * e.tangent;
  const Vec3 across = x[1] - e.a - along[1] * e.tangent - start;
  const double across2 = across.squaredNorm(), toward = -start.dot(across);
  if (toward < -interval_slack * across2 || toward > (1 + interval_slack) * across2) return std::nullopt;
  if (!(across2 > parallel_sine * parallel_sine * (x[1] - x[0]).squaredNorm())) return std::nullopt;
  for (const int i : ends) {
    if (on_feature(i, id.kind, id.index)) return std::nullopt;
    for (const int corner : e.corners) {
      // A cloth edge that starts at the edge's own end meets it there and nowhere else.
      if (corner >= 0 && on_feature(i, FeatureKind::Corner, corner)) return std::nullopt;
    }
  }
  const double s = std::clamp(toward / across2, 0.0, 1.0);
  const double t = along[0] + s * (along[1] - along[0]);
  if (t < -slack || t > e.length + slack) return std::nullopt;
  if (id.kind == FeatureKind::None && is_guarded_by_end(halfedge, s)) return std::nullopt;

  const Vec3 velocity = (1 - s) * relative_velocity(ends[0]) + s * relative_velocity(ends[1]);
  Vec3 normal = across.cross(e.tangent).normalized();
  double distance = normal.dot(start);
  const Sheet sheet = sheet_beside(cloth_.mesh, halfedge);
  const double side = e.free_cone ? wire_side(normal, distance, velocity, side_of_sheet(sheet.vertices), sheet.area)
                                  : normal.dot(e.mean);
  if (side < 0) {
    normal = -normal;
    distance = -distance;
  }
  if (!e.free_cone && !in_cone(e.normals, normal, e.tolerance)) return std::nullopt;
  const Vec3 on_feature = e.a + std::clamp(t, 0.0, e.length) * e.tangent, on_cloth = on_feature + distance * normal;
  if (!is_way_out({distance, reach(velocity), x, on_cloth, on_feature, e.normals})) return std::nullopt;

  Contact contact = make_contact(ContactType::EdgeEdge, on_feature, normal, distance);
  contact.feature = id;
  if (e.free_cone) contact.feature.side = normal.dot(sheet.area) < 0 ? -1 : 1;
  contact.n_vertices = 2;
  contact.vertices = {ends[0], ends[1], -1};
  contact.weights = {1 - s, s, 0};
  contact.halfedge = halfedge;
  return contact;
}

std::optional<Contact> NarrowPhase::corner_face(int corner, int face) const {
  const PlacedCorner& c = obstacle_.corners[static_cast<std::size_t>(corner)];
  const auto& vertices = cloth_.mesh.face(face);
  const auto x = world_corners(cloth_.mesh, face);
  const Vec3 face_side = face_normal(cloth_.mesh, face);
  Vec3 normal = face_side;
  if (normal.isZero()) return std::nullopt;
  Vec3 weights = foot_weights(x, c.position);
  if (!(weights.minCoeff() >= -interval_slack)) return std::nullopt;
  for (const int i : vertices) {
    if (on_feature(i, FeatureKind::Corner, corner)) return std::nullopt;
  }
  weights = weights.cwiseMax(0.0) / weights.cwiseMax(0.0).sum();
  Vec3 velocity = Vec3::Zero();
  for (int k = 0; k < 3; ++k) velocity += weights[k] * relative_velocity(vertices[static_cast<std::size_t>(k)]);
  const bool is_joint = c.normals.empty();
  const double side = is_joint
                          ? wire_side(normal, normal.dot(x[0] - c.position), velocity, side_of_sheet(vertices), normal)
                          : normal.dot(c.mean);
  if (side < 0) normal = -normal;
  if (!is_joint && !in_cone(c.normals, normal)) return std::nullopt;
  const double distance = normal.dot(x[0] - c.position);
  const Vec3 on_cloth = c.position + distance * normal;
  if (!is_way_out({distance, reach(velocity), x, on_cloth, c.position, c.normals})) return std::nullopt;

  Contact contact = make_contact(ContactType::CornerFace, c.position, normal, distance);
  contact.feature = {obstacle_.index, FeatureKind::Corner, corner};
  if (is_joint) contact.feature.side = normal.dot(face_side) < 0 ? -1 : 1;
  contact.n_vertices = 3;
  contact.vertices = vertices;
  contact.weights = {weights[0], weights[1], weights[2]};
  contact.face = face;
  return contact;
}

}  // namespace crease
