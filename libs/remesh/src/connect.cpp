// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <map>

#include "conforming.hpp"
#include "crease/geometry/chain.hpp"
#include "crease/geometry/triangle.hpp"
#include "guard.hpp"
#include "metric.hpp"
#include "strain.hpp"
#include "transfer.hpp"

// A chain is made link by link. The EOL vertices of one obstacle edge are sorted along it; two that follow each other
// are neighbours if the cloth between them lies on the edge, which is seen by walking straight from one to the other
// through the material: wherever the walk crosses a mesh edge, the cloth must be near the obstacle edge. (Several
// layers of cloth on one edge are told apart that way.) Where two crossed edges of a triangle were split one after the
// other, the link is a mesh edge already and only gets its tag; elsewhere the walk makes it, by splits and flips.
namespace crease {

namespace {

// A walk meets a vertex, not the edges beside it, within this share of `merge`.
constexpr double vertex_share = 0.1;
// Ends every walk; a link longer than this many triangles is none.
constexpr int max_walk = 64;
// Vertices ahead on the obstacle edge that are tried as a neighbour: those between may lie on other layers.
constexpr int max_lookahead = 8;
// Material length over world length between neighbours: the cloth between them is not bunched up.
constexpr double most_slack = 2;

// Where the straight way from vertex p to the material point X leaves the faces of p.
struct Exit {
  enum class Kind { None, Vertex, Edge } kind = Kind::None;
  int vertex = Mesh::none;
  int halfedge = Mesh::none;  // opposite to p
  double t = 0;               // along it
};

Exit exit_towards(const Mesh& mesh, int p, int q, double vertex_reach) {
  const Vec2 d = mesh.X[q] - mesh.X[p];
  const double length = d.norm();
  Exit best;
  double nearest = vertex_reach;
  for (const int u : mesh.neighbours(p)) {
    if (u == q) return {Exit::Kind::Vertex, q, Mesh::none, 0};
    const Vec2 e = mesh.X[u] - mesh.X[p];
    const double along = e.dot(d) / length, aside = std::abs(cross2(e, d)) / length;
    if (along <= 0 || along >= length || aside > nearest) continue;
    nearest = aside;
    best = {Exit::Kind::Vertex, u, Mesh::none, 0};
  }
  if (best.kind == Exit::Kind::Vertex) return best;
  for (const int h : mesh.outgoing(p)) {
    const Vec2 a = mesh.X[mesh.to(h)] - mesh.X[p], b = mesh.X[mesh.opposite(h)] - mesh.X[p];
    const double to_a = cross2(a, d), to_b = cross2(d, b);
    if (to_a < 0 || to_b < 0 || !(to_a + to_b > 0)) continue;
    return {Exit::Kind::Edge, Mesh::none, Mesh::next(h), to_a / (to_a + to_b)};
  }
  return best;
}

class Linker {
 public:
  Linker(Conforming& conforming, const FeatureId& feature)
      : c_(conforming),
        feature_(feature),
        tag_(edge_tag(feature.obstacle, feature.index)),
        edge_(world_edge(feature, conforming.obstacles)) {}

  void link(std::vector<int> members);

 private:
  const Mesh& mesh() const { return c_.mesh(); }
  double place(int v) const { return edge_.parameter(mesh().x[v]); }
  int linked(int v, bool ahead) const;
  bool has_link(int v, bool ahead) const { return linked(v, ahead) != Mesh::none; }
  bool could_follow(int p, int q) const;
  bool lies_near(const Vec3& x) const;
  Vec3 cloth_normal(int v) const;
  bool may_pass(int u) const;
  bool runs_along_border(int p, int q) const;
  bool is_on_feature(int p, int q) const;
  bool make_link(int p, int q);
  void take_in(int p);
  int step_to_vertex(int p, int u, int q);
  int step_over_edge(int p, int q, const Exit& exit);

  Conforming& c_;
  FeatureId feature_;
  int tag_;
  WorldEdge edge_;
};

int Linker::linked(int v, bool ahead) const {
  for (const int u : mesh().neighbours(v))
    if (mesh().tag(mesh().find_edge(v, u)) == tag_ && (place(u) > place(v)) == ahead) return u;
  return Mesh::none;
}

// A face with all three vertices on the obstacle edge has no area in the world: nothing holds it open, its vertices run
// together in the material. Its middle one belongs into the chain that passes it by; the face goes.
void Linker::take_in(int p) {
  const int q = linked(p, true);
  if (q == Mesh::none) return;
  for (const int h : {mesh().find_edge(p, q), mesh().twin(mesh().find_edge(p, q))}) {
    if (h == Mesh::none || mesh().is_border(h)) continue;
    const int m = mesh().opposite(h);
    if (!lies_on(c_.cloth().feature[m], feature_, c_.obstacles) || !c_.cloth().rides(m)) continue;
    if (!(place(p) < place(m) && place(m) < place(q)) || has_link(m, true) || has_link(m, false)) continue;
    c_.editor.set_tag(h, 0);
    if (!flip_check(c_.cloth(), h).sound) {
      c_.editor.set_tag(h, tag_);
      c_.editor.refuse(RefusalReason::NotConnected, m, mesh().X[m]);
      continue;
    }
    c_.editor.flip(h);
    c_.editor.set_tag(mesh().find_edge(p, m), tag_);
    c_.editor.set_tag(mesh().find_edge(m, q), tag_);
    return;
  }
}

bool Linker::could_follow(int p, int q) const {
  const double material = (mesh().X[q] - mesh().X[p]).norm(), world = place(q) - place(p);
  return material <= most_slack * world + c_.options.merge &&
         !was_left_between(c_.cloth(), feature_, place(p), place(q), c_.left_between());
}

bool Linker::lies_near(const Vec3& x) const {
  return stand_off(feature_, c_.obstacles, x) <= link_share * c_.options.snap &&
         (x - nearest_on(feature_, c_.obstacles, x)).norm() <= leave_share * c_.options.snap;
}

// Turned away from the obstacle; zero on a wire, which has no side.
Vec3 Linker::cloth_normal(int v) const {
  const PosedObstacle& obstacle = c_.obstacles[feature_.obstacle];
  const SharpEdge& edge = obstacle.shape->edges[feature_.index];
  if (edge.free_cone) return Vec3::Zero();
  Vec3 sum = Vec3::Zero();
  for (const int h : mesh().outgoing(v))
    sum += mesh().material_area(Mesh::face_of(h)) * face_normal(mesh(), Mesh::face_of(h));
  const double side = sum.dot(obstacle.pose.rotation * (edge.normals[0] + edge.normals[1]));
  return side == 0 ? Vec3::Zero() : Vec3(std::copysign(1.0, side) * sum.normalized());
}

// A vertex that has lifted off is a hole in the chain, not a link that is missing.
bool Linker::may_pass(int u) const {
  if (lies_on(c_.cloth().feature[u], feature_, c_.obstacles)) return c_.cloth().rides(u);
  return lies_near(mesh().x[u]) &&
         !separates(c_, feature_, {mesh().X[u], mesh().x[u], c_.cloth().world_velocity(u)}, cloth_normal(u));
}

// Where no chain begins none is linked either: it would soon be near enough to be let go.
bool Linker::runs_along_border(int p, int q) const {
  const Vec2 way = (mesh().X[q] - mesh().X[p]).normalized();
  const auto is_near = [&](int v) {
    return c_.border.distance_along(mesh().X[v], way, c_.border_cosine(1)) < c_.merge(insert_border_share);
  };
  return is_near(p) || is_near(q);
}

// The walk through the mesh as it is, without changing it.
bool Linker::is_on_feature(int p, int q) const {
  const Vec2 P = mesh().X[p], d = mesh().X[q] - P;
  Exit exit = exit_towards(mesh(), p, q, c_.merge(vertex_share));
  for (int i = 0; i < max_walk; ++i) {
    if (exit.kind == Exit::Kind::None) return false;
    if (exit.kind == Exit::Kind::Vertex) {
      if (exit.vertex == q) return true;
      if (!may_pass(exit.vertex)) return false;
      exit = exit_towards(mesh(), exit.vertex, q, c_.merge(vertex_share));
      continue;
    }
    const int h = exit.halfedge, g = mesh().twin(h);
    const Vec3 x = (1 - exit.t) * mesh().x[mesh().from(h)] + exit.t * mesh().x[mesh().to(h)];
    if (mesh().tag(h) != 0 && lies_near(x)) c_.editor.refuse_once(RefusalReason::NotConnected, mesh().X[p]);
    if (g == Mesh::none || mesh().tag(h) != 0 || !lies_near(x)) return false;
    const int apex = mesh().opposite(g);
    if (apex == q) return true;
    // Into the face behind: its apex is right or left of the way.
    const double side = cross2(d, mesh().X[apex] - P);
    const int out = side > 0 ? Mesh::next(g) : Mesh::prev(g);
    const double from = cross2(d, mesh().X[mesh().from(out)] - P), to = cross2(d, mesh().X[mesh().to(out)] - P);
    if (from == to) return false;
    exit = {Exit::Kind::Edge, Mesh::none, out, std::clamp(from / (from - to), 0.0, 1.0)};
  }
  return false;
}

// Each step either gets nearer to q for good (a tag is set) or removes a crossing; at most max_walk of them.
bool Linker::make_link(int p, int q) {
  for (int i = 0; i < max_walk && p != Mesh::none; ++i) {
    const Exit exit = exit_towards(mesh(), p, q, c_.merge(vertex_share));
    if (exit.kind == Exit::Kind::None) return false;
    p = exit.kind == Exit::Kind::Vertex ? step_to_vertex(p, exit.vertex, q) : step_over_edge(p, q, exit);
    if (p == q) return true;
  }
  return false;
}

// Returns where the walk goes on, none if it cannot.
int Linker::step_to_vertex(int p, int u, int q) {
  const bool is_member = lies_on(c_.cloth().feature[u], feature_, c_.obstacles) && c_.cloth().rides(u);
  if (u != q && !is_member) {
    const Vec2 d = (mesh().X[q] - mesh().X[p]).normalized();
    const SurfacePoint here{mesh().X[u], mesh().x[u], c_.cloth().v[u]};
    if (!may_pass(u)) return Mesh::none;
    if (passes_by(c_, u, here.X, feature_, c_.merge(cross_insert_share))) return Mesh::none;
    if (inadmissible(c_, here.X, d, Mesh::none) || !adopt(c_, u, here, feature_, false)) return Mesh::none;
  }
  c_.editor.set_tag(mesh().find_edge(p, u), tag_);
  return u;
}

int Linker::step_over_edge(int p, int q, const Exit& exit) {
  const int h = exit.halfedge;
  if (mesh().is_border(h) || mesh().tag(h) != 0) return Mesh::none;
  const FlipCheck check = flip_check(c_.cloth(), h);
  const bool reaches = mesh().opposite(mesh().twin(h)) == q;
  const bool may_flip = check.sound && strain_gained_by_flip(mesh(), h) <= needed_strain;
  if (reaches && may_flip && check.angle >= std::min(least_angle, check.angle_before)) {
    c_.editor.flip(h);
    return p;
  }
  const SurfacePoint point = on_edge_point(c_.cloth(), h, exit.t);
  const Vec2 way = (mesh().X[q] - mesh().X[p]).normalized();
  if (lies_near(point.x) && !separates(c_, feature_, point, cloth_normal(p)) &&
      !passes_by(c_, mesh().from(h), point.X, feature_, c_.merge(cross_insert_share)) &&
      !passes_by(c_, mesh().to(h), point.X, feature_, c_.merge(cross_insert_share)) &&
      !inadmissible(c_, point.X, way, Mesh::none)) {
    const int m = insert_on_edge(c_, h, exit.t, feature_);
    if (m == Mesh::none) return Mesh::none;
    c_.editor.set_tag(mesh().find_edge(p, m), tag_);
    return m;
  }
  if (!may_flip) return Mesh::none;
  c_.editor.flip(h);
  return p;
}

void Linker::link(std::vector<int> members) {
  std::sort(members.begin(), members.end(),
            [&](int p, int q) { return std::pair(place(p), p) < std::pair(place(q), q); });
  for (std::size_t i = 0; i + 1 < members.size(); ++i) {
    const int p = members[i];
    if (has_link(p, true)) {
      take_in(p);
      continue;
    }
    const std::size_t end = std::min(members.size(), i + 1 + max_lookahead);
    for (std::size_t j = i + 1; j < end; ++j) {
      const int q = members[j];
      if (has_link(q, false) || !could_follow(p, q) || !is_on_feature(p, q)) continue;
      if (runs_along_border(p, q))
        c_.editor.refuse_once(RefusalReason::NearBorder, mesh().X[p]);
      else if (!make_link(p, q))
        c_.editor.refuse(RefusalReason::NotConnected, p, mesh().X[p]);
      break;
    }
  }
}

// EOL vertices by the obstacle edge they are on; corners are on several.
std::map<int, std::vector<int>> members_by_edge(const Conforming& c) {
  std::map<int, std::vector<int>> members;
  for (int v = 0; v < c.mesh().vertex_slots(); ++v) {
    if (!c.mesh().vertex_live(v) || !c.cloth().rides(v)) continue;
    const FeatureId& f = c.cloth().feature[v];
    if (f.kind == FeatureKind::Edge) {
      members[edge_tag(f.obstacle, f.index)].push_back(v);
      continue;
    }
    const std::vector<SharpEdge>& edges = c.obstacles[f.obstacle].shape->edges;
    for (int e = 0; e < static_cast<int>(edges.size()); ++e)
      if (edges[e].corners[0] == f.index || edges[e].corners[1] == f.index)
        members[edge_tag(f.obstacle, e)].push_back(v);
  }
  return members;
}

}  // namespace

void connect_chains(Conforming& c) {
  for (const auto& [tag, members] : members_by_edge(c))
    if (members.size() > 1) Linker(c, tag_feature(tag)).link(members);
}

}  // namespace crease
