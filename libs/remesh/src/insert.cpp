// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <tuple>

#include <Eigen/Geometry>

#include "conforming.hpp"
#include "crease/geometry/chain.hpp"
#include "crease/geometry/triangle.hpp"
#include "guard.hpp"
#include "metric.hpp"
#include "strain.hpp"
#include "transfer.hpp"

// Insertion changes the mesh under the contacts' feet. Vertex ids stay valid, so a contact finds its edge or face again
// by its vertices; where that is gone, the next call sees the crossing again.
namespace crease {

namespace {

// A slide may take this share of a triangle's altitude.
constexpr double slide_altitude_loss = 0.5;
// A new vertex is not put nearer to the rim of its face or edge than this share of `merge`; the mesh asks for more than
// 0.
constexpr double least_gap_share = 0.02;
// A motion that leaves a feature rises by at least this over the way it goes; less is round-off of a sliding one.
constexpr double separating_sine = 1e-3;
// ... and at this speed [m/s]; less is what a solver leaves of a cloth at rest.
constexpr double separating_speed = 1e-9;
// ... and has got away by at least this share of `snap`, else the direction away from the feature is not known ...
constexpr double separating_gap_share = 1e-6;
// ... and is not deeper inside than this share: such a point has to come out to the feature first.
constexpr double separating_depth_share = 0.1;

bool may_ride(const Conforming& c, int v) {
  if (c.cloth().is_eol(v) || c.cloth().pins[v] != 0 || c.mesh().on_seam(v)) return false;
  return !c.mesh().is_border_vertex(v) || !c.mesh().is_material_corner(v);
}

// Whether the faces of v keep their orientation, and most of their altitude, with v at X.
bool can_slide(const Mesh& mesh, int v, const Vec2& X) {
  for (const int h : mesh.outgoing(v)) {
    const Vec2 &b = mesh.X[mesh.to(h)], &c = mesh.X[mesh.opposite(h)];
    if (!(orient2d(X, b, c) > 0)) return false;
    if (smallest_altitude({X, b, c}) < slide_altitude_loss * smallest_altitude({mesh.X[v], b, c})) return false;
  }
  return true;
}

// A face whose other two corners are on the edge already would have no area in the world.
bool closes_a_line(const Conforming& c, int v, const FeatureId& feature) {
  if (feature.kind != FeatureKind::Edge) return false;
  for (const int h : c.mesh().outgoing(v))
    if (lies_on(c.cloth().feature[c.mesh().to(h)], feature, c.obstacles) &&
        lies_on(c.cloth().feature[c.mesh().opposite(h)], feature, c.obstacles))
      return true;
  return false;
}

Mat32 edge_gradient(const Mesh& mesh, int h) {
  Mat32 F = Mat32::Zero();
  for (const int side : {h, mesh.twin(h)})
    if (side != Mesh::none)
      F += mesh.material_area(Mesh::face_of(side)) * deformation_gradient(mesh, Mesh::face_of(side));
  return F;  // only its direction matters
}

struct Crossing {
  int rank;    ///< 0: an end on the border may be used, 1: another end, 2: a new vertex
  double gap;  ///< material distance to the nearer end [m]
  int contact;
};

// The cloth edge of a contact as it is now, and the parameter along it; none if it is gone.
std::pair<int, double> locate(const Mesh& mesh, const Contact& contact) {
  const int h = mesh.find_edge(contact.vertices[0], contact.vertices[1]);
  if (h == Mesh::none) return {h, 0};
  return {h, std::clamp(mesh.from(h) == contact.vertices[0] ? contact.weights[1] : contact.weights[0], 0.0, 1.0)};
}

double adopt_reach(const Conforming& c, int h) {
  // The border is met at the border angle at least, so a chain that passes an inner edge near a border vertex meets
  // the border edge not much farther from it.
  return c.merge(c.mesh().is_border(h) ? 2 * adopt_share : adopt_share);
}

// Where a chain has just ended, it was for a reason that may last: one that begins there at once ends again, and so on.
bool was_left(const Conforming& c, const Contact& contact) {
  const bool is_edge = contact.feature.kind == FeatureKind::Edge;
  return was_left(c.cloth(), contact.feature,
                  is_edge ? world_edge(contact.feature, c.obstacles).parameter(contact.point) : 0.0);
}

// The sign of the gap tells in from out: what is inside has to come out, what is outside has to arrive first.
bool wanted(const Conforming& c, const Contact& contact, FeatureKind kind) {
  return contact.feature.kind == kind && contact.distance <= begin_share * c.options.snap &&
         contact.distance >= -c.options.snap && exists(contact.feature, c.obstacles) &&
         !stands_back(contact.feature, c.obstacles, contact.point, aside_insert_share * c.options.snap) &&
         !was_left(c, contact);
}

// Border ends first, since inner edges cannot move them; then the nearest ends, so that vertices move least.
std::vector<Crossing> ordered_crossings(const Conforming& c, std::span<const Contact> contacts) {
  std::vector<Crossing> crossings;
  for (int i = 0; i < static_cast<int>(contacts.size()); ++i) {
    if (contacts[i].type != ContactType::EdgeEdge || !wanted(c, contacts[i], FeatureKind::Edge)) continue;
    const auto [h, t] = locate(c.mesh(), contacts[i]);
    if (h == Mesh::none) continue;
    const double gap = std::min(t, 1 - t) * c.mesh().material_length(h);
    const int rank = gap > adopt_reach(c, h) ? 2 : c.mesh().is_border(h) ? 0 : 1;
    crossings.push_back({rank, rank == 2 ? 0.0 : gap, i});
  }
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& p, const Crossing& q) {
    return std::tie(p.rank, p.gap, p.contact) < std::tie(q.rank, q.gap, q.contact);
  });
  return crossings;
}

// A fold that has just lifted off is the fold of this edge for as long as its faces reach over it.
bool is_beside_lifted(const Conforming& c, int h, const FeatureId& feature) {
  for (const int side : {h, c.mesh().twin(h)}) {
    if (side == Mesh::none) continue;
    const FeatureId& other = c.cloth().feature[c.mesh().opposite(side)];
    if (other.lifted && other == feature) return true;
  }
  return false;
}

// Beside a rider that it may not be linked to, a new one would have to give way to it. Round a vertex that would be
// taken for it, one may ride that is in neither face of the cloth edge.
bool is_beside_parted(const Conforming& c, int h, const Vec3& x, const FeatureId& feature, int taken) {
  if (c.cloth().left.empty()) return false;
  std::vector<int> around;
  if (taken != Mesh::none) around = c.mesh().neighbours(taken);
  for (const int side : {h, c.mesh().twin(h)})
    if (side != Mesh::none) around.insert(around.end(), {c.mesh().from(side), c.mesh().opposite(side)});
  return std::any_of(around.begin(), around.end(), [&](int u) { return is_parted(c, feature, x, u); });
}

void insert_crossing(Conforming& c, const Contact& contact) {
  const auto [h, t] = locate(c.mesh(), contact);
  if (h == Mesh::none) return;
  if (c.mesh().tag(h) != 0 && gives_way(tag_feature(c.mesh().tag(h)), contact.feature, c.obstacles))
    c.editor.set_tag(h, 0);
  if (c.mesh().tag(h) != 0) {
    c.editor.refuse_once(RefusalReason::NotConnected, on_edge_point(c.cloth(), h, t).X);
    return;
  }
  const int a = c.mesh().from(h), b = c.mesh().to(h);
  for (const int v : {a, b})
    if (lies_on(c.cloth().feature[v], contact.feature, c.obstacles)) return;
  if (is_beside_lifted(c, h, contact.feature)) return;
  const SurfacePoint point = on_edge_point(c.cloth(), h, t);
  const int end = t < 0.5 ? a : b;
  const double gap = std::min(t, 1 - t) * c.mesh().material_length(h);
  if (is_beside_parted(c, h, point.x, contact.feature, gap <= adopt_reach(c, h) ? end : Mesh::none)) return;
  if (separates(c, contact.feature, point, contact.normal)) {
    c.editor.refuse_once(RefusalReason::Separating, point.X);
    return;
  }
  const Vec3 tangent = world_edge(contact.feature, c.obstacles).tangent;
  const Vec2 direction = pull_back(edge_gradient(c.mesh(), h), tangent);
  // An exact hit on a border vertex is a hit on the border, whichever edge reported it.
  const bool at_border_vertex = gap <= c.merge(least_gap_share) && c.mesh().is_border_vertex(end);
  const int border_edge = c.mesh().is_border(h) ? h : at_border_vertex ? c.mesh().halfedge(end) : Mesh::none;
  if (at_border_vertex && c.mesh().on_seam(end)) {
    c.editor.refuse_once(RefusalReason::OnSeam, point.X);
    return;
  }
  if (const auto reason = inadmissible(c, point.X, direction, border_edge)) {
    c.editor.refuse_once(*reason, point.X);
    return;
  }
  const auto is_taken = [&](int v) {
    const double reach = c.merge(cross_insert_share);
    return passes_by(c, v, point.X, contact.feature, reach) ||
           (border_edge != Mesh::none && ends_beside(c, v, point.X, contact.feature, reach));
  };
  if (is_taken(a) || is_taken(b)) {
    c.editor.refuse_once(RefusalReason::NotConnected, point.X);
    return;
  }
  // This near to a border the chain's end there is all that is wanted: another vertex would be merged into it.
  if (border_edge == Mesh::none && c.border.distance(point.X) < c.merge(insert_border_share)) return;
  if (gap <= adopt_reach(c, h) && adopt(c, end, point, contact.feature, c.mesh().is_border(h))) return;
  if (gap <= c.merge(least_gap_share) || insert_on_edge(c, h, t, contact.feature) == Mesh::none)
    c.editor.refuse(RefusalReason::WouldInvert, Mesh::none, point.X);
}

// The face that holds P among those round the given vertices; none if it has left them.
int face_with(const Mesh& mesh, const Contact& contact, const Vec2& P) {
  for (int k = 0; k < contact.n_vertices; ++k)
    for (const int h : mesh.outgoing(contact.vertices[k]))
      if (barycentric(material_corners(mesh, Mesh::face_of(h)), P).minCoeff() >= -1e-12) return Mesh::face_of(h);
  return Mesh::none;
}

// A vertex near enough to become the corner's: a free one, or one that rides on an edge that ends there.
bool adopt_nearest(Conforming& c, int face, const SurfacePoint& point, const FeatureId& corner) {
  const std::array<int, 3> vertices = c.mesh().face(face);
  const auto distance = [&](int v) { return (c.mesh().X[v] - point.X).norm(); };
  const int v =
      *std::min_element(vertices.begin(), vertices.end(), [&](int p, int q) { return distance(p) < distance(q); });
  if (distance(v) > c.merge(adopt_share) || c.mesh().is_border_vertex(v)) return false;
  // Of a steep cone the tip stays where it is; what is left beside it will be absorbed when that costs less.
  if (distance(v) > c.merge(least_gap_share) && strain_gained(c.mesh(), v, {point.X, point.x}) > unfelt_strain)
    return false;
  const FeatureId feature = c.cloth().feature[v];
  if (feature.kind == FeatureKind::Edge && lies_on(corner, feature, c.obstacles) && can_slide(c.mesh(), v, point.X))
    c.editor.release(v);
  return adopt(c, v, point, corner, false);
}

// A new vertex at the point of a face. Next to a side the side is split and the vertex moved to its place: one inside
// the face would leave a sliver.
int split_at(Conforming& c, int face, const SurfacePoint& point) {
  for (int k = 0; k < 3; ++k) {
    const int h = 3 * face + k;
    const Vec2 start = c.mesh().X[c.mesh().from(h)], e = c.mesh().X[c.mesh().to(h)] - start;
    const double height = cross2(e, point.X - start) / e.norm();
    if (height > c.merge(adopt_share)) continue;
    const double t = e.dot(point.X - start) / e.squaredNorm();
    if (c.mesh().is_border(h) || c.mesh().tag(h) != 0 || !c.mesh().can_split(h, t)) continue;
    if (height > c.merge(least_gap_share) && strain_gained_by_split(c.mesh(), h, {point.X, point.x}) > unfelt_strain)
      continue;
    const int v = c.editor.split(h, t).vertex;
    if (can_slide(c.mesh(), v, point.X)) {
      c.editor.slide(v, point.X, point.x, point.v);
      return v;
    }
    return Mesh::none;
  }
  const Vec3 b = barycentric(material_corners(c.mesh(), face), point.X);
  return c.mesh().can_split_face(face, b) ? c.editor.split_face(face, b).vertex : Mesh::none;
}

// Whether a vertex rides on the corner already, of the same layer of cloth: one that hovers may stand in another face
// than the one over the tip, and two that ride on one point have no room between them.
bool has_rider(const Conforming& c, const FeatureId& corner, const Vec2& P) {
  for (int v = 0; v < c.mesh().vertex_slots(); ++v)
    if (c.mesh().vertex_live(v) && c.cloth().feature[v] == corner && (c.mesh().X[v] - P).norm() < c.options.merge)
      return true;
  return false;
}

void insert_corner(Conforming& c, const Contact& contact) {
  Vec2 P = Vec2::Zero();
  for (int k = 0; k < 3; ++k) P += contact.weights[k] * c.mesh().X[contact.vertices[k]];
  const int face = face_with(c.mesh(), contact, P);
  if (face == Mesh::none) return;
  if (has_rider(c, contact.feature, P)) return;
  const std::array<int, 3> corners = c.mesh().face(face);
  const Vec3 b = barycentric(material_corners(c.mesh(), face), P).cwiseMax(0.0);
  SurfacePoint point{P, Vec3::Zero(), Vec3::Zero()};
  const std::array<Vec3, 3> w = corner_velocities(c.cloth(), face);
  for (int k = 0; k < 3; ++k) {
    point.x += b[k] * c.mesh().x[corners[k]];
    point.v += b[k] * w[k];
  }
  if (separates(c, contact.feature, point, contact.normal)) {
    c.editor.refuse_once(RefusalReason::Separating, point.X);
    return;
  }
  if (c.border.distance(P) < c.merge(insert_border_share)) {
    c.editor.refuse_once(RefusalReason::NearBorder, P);
    return;
  }
  if (adopt_nearest(c, face, point, contact.feature)) return;
  const int v = split_at(c, face, point);
  if (v == Mesh::none) {
    c.editor.refuse(RefusalReason::WouldInvert, Mesh::none, P);
    return;
  }
  c.editor.ride(v, contact.feature, c.mesh().x[v]);
  c.newcomers.push_back(v);
}

}  // namespace

SurfacePoint on_edge_point(const Cloth& cloth, int h, double t) {
  const Mesh& mesh = cloth.mesh;
  const int a = mesh.from(h), b = mesh.to(h);
  return {(1 - t) * mesh.X[a] + t * mesh.X[b], (1 - t) * mesh.x[a] + t * mesh.x[b], edge_velocity(cloth, h, t)};
}

std::optional<RefusalReason> inadmissible(const Conforming& c, const Vec2& P, const Vec2& direction, int border_edge) {
  if (c.border.corner_distance(P) < c.options.merge) return RefusalReason::AtCorner;
  if (border_edge != Mesh::none) {
    if (c.mesh().seam_twin(border_edge) != Mesh::none) return RefusalReason::OnSeam;
    const Vec2 e = c.mesh().X[c.mesh().to(border_edge)] - c.mesh().X[c.mesh().from(border_edge)];
    if (std::abs(e.dot(direction)) > c.border_cosine(1) * e.norm()) return RefusalReason::NearBorder;
    return std::nullopt;
  }
  const double distance = c.border.distance_along(P, direction, c.border_cosine(1));
  if (distance < c.merge(insert_border_share)) return RefusalReason::NearBorder;
  return std::nullopt;
}

// What has just lifted off would else be caught again at once, since it is still within the contact threshold.
bool separates(const Conforming& c, const FeatureId& feature, const SurfacePoint& point, const Vec3& normal) {
  const PosedObstacle& obstacle = c.obstacles[feature.obstacle];
  const double snap = c.options.snap;
  const std::optional<double> outside = signed_distance(*obstacle.shape, obstacle.pose, point.x);
  if (outside && *outside < -separating_depth_share * snap) return false;
  const Vec3 away = point.x - nearest_on(feature, c.obstacles, point.x);
  // Points and wires have no inside, but a side that the cloth belongs on: from behind them it has to come out first.
  if (!outside && normal.dot(away) < -separating_gap_share * snap) return false;
  const Vec3 motion = point.v - velocity_at(feature, c.obstacles, point.x);
  const double least = std::max(separating_sine * motion.norm(), separating_speed);
  const bool has_direction = away.norm() > separating_gap_share * snap && (!outside || *outside > 0);
  return (has_direction && away.dot(motion) > least * away.norm()) || normal.dot(motion) > least;
}

bool adopt(Conforming& c, int vertex, const SurfacePoint& point, const FeatureId& feature, bool along_border) {
  if (!may_ride(c, vertex) || closes_a_line(c, vertex, feature)) return false;
  if (point.X != c.mesh().X[vertex]) {
    const bool stays = (point.X - c.mesh().X[vertex]).norm() <= 1e-9 * c.options.merge;
    if (c.mesh().is_border_vertex(vertex) && !along_border && !stays) return false;
    if (!stays) {
      if (!can_slide(c.mesh(), vertex, point.X)) return false;
      c.editor.slide(vertex, point.X, point.x, point.v);
    }
  }
  c.editor.ride(vertex, feature, c.mesh().x[vertex]);
  c.newcomers.push_back(vertex);
  return true;
}

int insert_on_edge(Conforming& c, int h, double t, const FeatureId& feature) {
  if (!c.mesh().can_split(h, t)) return Mesh::none;
  const int v = c.editor.split(h, t).vertex;
  c.editor.ride(v, feature, c.mesh().x[v]);
  c.newcomers.push_back(v);
  return v;
}

// Corners first: the edges that end there then find them.
void insert_contacts(Conforming& c, std::span<const Contact> contacts) {
  for (const Contact& contact : contacts)
    if (contact.type == ContactType::CornerFace && wanted(c, contact, FeatureKind::Corner)) insert_corner(c, contact);
  for (const Crossing& crossing : ordered_crossings(c, contacts)) insert_crossing(c, contacts[crossing.contact]);
}

}  // namespace crease
