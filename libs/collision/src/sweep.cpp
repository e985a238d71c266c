// SPDX-License-Identifier: MIT
#include "sweep.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "crease/geometry/normal_cone.hpp"

namespace crease {
namespace {

// A feature may miss a face's rim, or an edge's end, by this share of it: round-off where it passes through a vertex.
constexpr double rim_slack = 1e-9;

// Two edges nearer to parallel than this have no common normal worth the name: sine of 2 degrees.
constexpr double parallel_sine = 0.0349;

// a[0] + a[1] s + a[2] s^2 + a[3] s^3
struct Cubic {
  std::array<double, 4> a{};
  double operator()(double s) const { return a[0] + s * (a[1] + s * (a[2] + s * a[3])); }
};

// A sign change of f in [0, 1].
struct Passing {
  double time;
  double side;  // sign of f before
};

// Bisection to round-off, which is what 60 halvings of [0, 1] are. @pre the signs of f at its ends differ
double bisect(const Cubic& f, double low, double high) {
  const bool rises = f(low) < 0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    ((f(middle) < 0) == rises ? low : high) = middle;
  }
  return high;
}

// Between the roots of its derivative f is monotone. Ascending; what only touches zero passes nothing.
std::vector<Passing> passings(const Cubic& f) {
  std::vector<double> ends{0.0};
  const double c = f.a[1], b = 2 * f.a[2], a = 3 * f.a[3], discriminant = b * b - 4 * a * c;
  if (discriminant >= 0) {
    // The stable form: of a derivative that is nearly linear one root is far away or not finite, and is not in (0, 1).
    const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
    std::array<double, 2> roots{q / a, c / q};
    if (roots[1] < roots[0]) std::swap(roots[0], roots[1]);
    for (const double s : roots)
      if (s > 0 && s < 1) ends.push_back(s);
    std::sort(ends.begin(), ends.end());
  }
  ends.push_back(1.0);
  std::vector<Passing> found;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const double before = f(ends[i]), after = f(ends[i + 1]);
    if (before * after < 0) found.push_back({bisect(f, ends[i], ends[i + 1]), before < 0 ? -1.0 : 1.0});
  }
  return found;
}

// A vector that changes evenly from s = 0 to 1.
struct Way {
  Vec3 start, change;
  Vec3 at(double s) const { return start + s * change; }
};

Way operator-(const Way& p, const Way& q) {
  return {p.start - q.start, p.change - q.change};
}

// (u x v) . w
Cubic triple(const Way& u, const Way& v, const Way& w) {
  const Vec3 n0 = u.start.cross(v.start), n1 = u.start.cross(v.change) + u.change.cross(v.start),
             n2 = u.change.cross(v.change);
  return {{n0.dot(w.start), n1.dot(w.start) + n0.dot(w.change), n2.dot(w.start) + n1.dot(w.change), n2.dot(w.change)}};
}

// The feature as it is looked for, this deep inside: what lies on it is outside, but for round-off, and that must not
// hide its passing. A wire has no inside.
Vec3 sunk(const Vec3& point, std::span<const Vec3> normals, double depth) {
  return normals.empty() ? point : Vec3(point - depth * mean_normal(normals));
}

Way still(const Vec3& p) {
  return {p, Vec3::Zero()};
}

class Sweep {
 public:
  Sweep(const Cloth& cloth, const PlacedObstacle& obstacle, double h, double depth);
  void append_edges(std::vector<Contact>& contacts) const;
  void append_corners(std::vector<Contact>& contacts) const;

 private:
  const ObstacleShape& shape() const { return *obstacle_.source.shape; }
  bool rides_on(int vertex, const FeatureId& id) const { return cloth_.rides(vertex) && cloth_.feature[vertex] == id; }
  bool is_guarded(int halfedge, int edge) const;
  std::vector<int> faces_near(const Eigen::AlignedBox3d& bounds) const;
  std::optional<Contact> pass_edge(int halfedge, int edge) const;
  /// `time`: of a meeting earlier than that, replaced by its own.
  std::optional<Contact> pass_corner(int face, int corner, double& time) const;
  bool ends_behind(const Contact& contact, const Vec3& point, const Vec3& normal) const;
  void finish(Contact& contact, const Vec3& point, const Vec3& normal) const;

  const Cloth& cloth_;
  const PlacedObstacle& obstacle_;
  double h_, depth_;
  Pose end_;
  std::vector<Way> x_;                       // of the vertices, in the obstacle's frame
  std::vector<int> faces_;                   // that come near any feature
  std::vector<Eigen::AlignedBox3d> bounds_;  // of their ways
};

Sweep::Sweep(const Cloth& cloth, const PlacedObstacle& obstacle, double h, double depth)
    : cloth_(cloth), obstacle_(obstacle), h_(h), depth_(depth), end_(pose_after(obstacle.source.pose, h)) {
  const Mesh& mesh = cloth.mesh;
  x_.resize(mesh.x.size());
  for (int i = 0; i < mesh.vertex_slots(); ++i) {
    const Vec3 start = obstacle.source.pose.to_local(mesh.x[i]);
    x_[i] = {start, end_.to_local(mesh.x[i] + h * cloth.v[i]) - start};
  }
  Eigen::AlignedBox3d all;
  for (const SharpEdge& edge : shape().edges) all.extend(edge.a).extend(edge.b);
  for (const SharpCorner& corner : shape().corners) all.extend(corner.position);
  for (int f = 0; f < mesh.face_slots() && !all.isEmpty(); ++f) {
    if (!mesh.face_live(f)) continue;
    Eigen::AlignedBox3d bounds;
    for (const int i : mesh.face(f)) bounds.extend(x_[i].start).extend(x_[i].at(1));
    bounds = {bounds.min().array() - depth, bounds.max().array() + depth};
    if (!bounds.intersects(all)) continue;
    faces_.push_back(f);
    bounds_.push_back(bounds);
  }
}

std::vector<int> Sweep::faces_near(const Eigen::AlignedBox3d& bounds) const {
  std::vector<int> near;
  for (std::size_t k = 0; k < faces_.size(); ++k)
    if (bounds_[k].intersects(bounds)) near.push_back(faces_[k]);
  return near;
}

// Beside a vertex that rides on the edge, or on the corner where it ends, that vertex's rows keep the cloth out.
bool Sweep::is_guarded(int halfedge, int edge) const {
  for (const int i : {cloth_.mesh.from(halfedge), cloth_.mesh.to(halfedge)}) {
    if (rides_on(i, {obstacle_.index, FeatureKind::Edge, edge})) return true;
    for (const int corner : shape().edges[edge].corners)
      if (corner >= 0 && rides_on(i, {obstacle_.index, FeatureKind::Corner, corner})) return true;
  }
  return false;
}

// Whether the motion takes the contact's point behind the plane by more than what is allowed.
bool Sweep::ends_behind(const Contact& contact, const Vec3& point, const Vec3& normal) const {
  Vec3 x = Vec3::Zero();
  for (int k = 0; k < contact.n_vertices; ++k) x += contact.weights[k] * x_[contact.vertices[k]].at(1);
  return normal.dot(x - point) < -depth_;
}

void Sweep::finish(Contact& contact, const Vec3& point, const Vec3& normal) const {
  Vec3 x = Vec3::Zero();
  for (int k = 0; k < contact.n_vertices; ++k) x += contact.weights[k] * cloth_.mesh.x[contact.vertices[k]];
  contact.obstacle = contact.feature.obstacle = obstacle_.index;
  contact.point = obstacle_.source.pose.to_world(point);
  contact.normal = obstacle_.source.pose.rotation * normal;
  contact.velocity = (end_.to_world(point) - x) / h_;
}

std::optional<Contact> Sweep::pass_edge(int halfedge, int edge) const {
  const SharpEdge& sharp = shape().edges[edge];
  const Way &p = x_[cloth_.mesh.from(halfedge)], &q = x_[cloth_.mesh.to(halfedge)];
  const Vec3 along = sharp.b - sharp.a;
  std::span<const Vec3> normals;
  if (!sharp.free_cone) normals = sharp.normals;
  const Vec3 place = sunk(sharp.a, normals, depth_);
  for (const Passing& passing : passings(triple(q - p, still(along), p - still(place)))) {
    const Vec3 a = p.at(passing.time), e = q.at(passing.time) - a, n = e.cross(along);
    if (!(n.norm() > parallel_sine * e.norm() * along.norm())) continue;
    // a + s e = place + t along, both in the plane across n.
    const Vec3 from = place - a;
    const double s = from.cross(along).dot(n) / n.squaredNorm(), t = from.cross(e).dot(n) / n.squaredNorm();
    if (std::min(s, t) < -rim_slack || std::max(s, t) > 1 + rim_slack) continue;
    const Vec3 normal = passing.side * n.normalized(), point = sharp.a + std::clamp(t, 0.0, 1.0) * along;
    if (!normals.empty() && !in_cone(normals, normal)) continue;
    Contact contact{.type = ContactType::EdgeEdge, .feature = {-1, FeatureKind::Edge, edge}};
    contact.n_vertices = 2;
    contact.vertices = {cloth_.mesh.from(halfedge), cloth_.mesh.to(halfedge), -1};
    contact.weights = {1 - std::clamp(s, 0.0, 1.0), std::clamp(s, 0.0, 1.0), 0};
    contact.halfedge = halfedge;
    if (!ends_behind(contact, point, normal)) continue;
    finish(contact, point, normal);
    return contact;
  }
  return std::nullopt;
}

std::optional<Contact> Sweep::pass_corner(int face, int corner, double& time) const {
  const SharpCorner& sharp = shape().corners[corner];
  const std::array<int, 3>& v = cloth_.mesh.face(face);
  const Way &p = x_[v[0]], &q = x_[v[1]], &r = x_[v[2]];
  const Vec3 o = sunk(sharp.position, sharp.normals, depth_);
  for (const Passing& passing : passings(triple(q - p, r - p, p - still(o)))) {
    if (passing.time >= time) return std::nullopt;
    const Vec3 a = p.at(passing.time), b = q.at(passing.time), c = r.at(passing.time);
    const Vec3 n = (b - a).cross(c - a);
    if (!(n.norm() > 0)) continue;
    Vec3 weights(n.dot((b - o).cross(c - o)), n.dot((c - o).cross(a - o)), n.dot((a - o).cross(b - o)));
    weights /= n.squaredNorm();
    if (!(weights.minCoeff() >= -rim_slack)) continue;
    weights = weights.cwiseMax(0.0) / weights.cwiseMax(0.0).sum();
    const Vec3 normal = passing.side * n.normalized();
    if (!sharp.normals.empty() && !in_cone(sharp.normals, normal)) continue;
    Contact contact{.type = ContactType::CornerFace, .feature = {-1, FeatureKind::Corner, corner}};
    contact.n_vertices = 3;
    contact.vertices = v;
    contact.weights = {weights[0], weights[1], weights[2]};
    contact.face = face;
    if (!ends_behind(contact, sharp.position, normal)) continue;
    finish(contact, sharp.position, normal);
    time = passing.time;
    return contact;
  }
  return std::nullopt;
}

void Sweep::append_edges(std::vector<Contact>& contacts) const {
  for (int e = 0; e < static_cast<int>(shape().edges.size()) && !faces_.empty(); ++e) {
    Eigen::AlignedBox3d bounds(shape().edges[e].a);
    std::vector<int> edges;
    for (const int f : faces_near(bounds.extend(shape().edges[e].b)))
      for (int k = 0; k < 3; ++k) edges.push_back(cloth_.mesh.edge_of(3 * f + k));
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    for (const int halfedge : edges) {
      if (is_guarded(halfedge, e)) continue;
      if (const auto contact = pass_edge(halfedge, e)) contacts.push_back(*contact);
    }
  }
}

void Sweep::append_corners(std::vector<Contact>& contacts) const {
  for (int c = 0; c < static_cast<int>(shape().corners.size()) && !faces_.empty(); ++c) {
    std::optional<Contact> first;
    double time = 1;
    for (const int f : faces_near(Eigen::AlignedBox3d(shape().corners[c].position))) {
      const std::array<int, 3>& v = cloth_.mesh.face(f);
      const FeatureId id{obstacle_.index, FeatureKind::Corner, c};
      if (std::any_of(v.begin(), v.end(), [&](int i) { return rides_on(i, id); })) continue;
      if (const auto contact = pass_corner(f, c, time)) first = contact;
    }
    if (first) contacts.push_back(*first);
  }
}

}  // namespace

std::vector<Contact> passed_features(const Cloth& cloth, const PlacedObstacle& obstacle, double h, double depth) {
  const Sweep sweep(cloth, obstacle, h, depth);
  std::vector<Contact> contacts;
  sweep.append_edges(contacts);
  sweep.append_corners(contacts);
  return contacts;
}

}  // namespace crease
