// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <utility>

#include "conforming.hpp"
#include "crease/geometry/chain.hpp"

namespace crease {

namespace {

bool has_left(const Conforming& c, int v) {
  const FeatureId& feature = c.cloth().feature[v];
  if (!exists(feature, c.obstacles)) return true;
  if (feature.lifted) return false;  // nowhere is its place; how long it is a fold, the stepper sees
  const double reach = leave_share * c.options.snap;
  const Vec3& x = c.mesh().x[v];
  if (stands_back(feature, c.obstacles, x, aside_share * c.options.snap)) return true;
  // Past the end of an edge the nearest point is its end, so this covers it too.
  return (x - nearest_on(feature, c.obstacles, x)).norm() > reach;
}

// On the border: its chain has turned to run along it.
bool hugs_border(const Conforming& c, int v) {
  const Mesh& mesh = c.mesh();
  const Vec2 normal = border_normal(mesh, v);
  const double limit = c.border_cosine(release_angle_share);
  for (const int u : mesh.neighbours(v)) {
    if (mesh.tag(mesh.find_edge(v, u)) == 0) continue;
    const Vec2 e = mesh.X[u] - mesh.X[v];
    if (std::abs(e.x() * normal.y() - e.y() * normal.x()) > limit * e.norm()) return true;
  }
  return false;
}

// A chain that meets the border crosswise ends there in a vertex; at which angle is asked separately.
bool ends_at_border_beside(const Conforming& c, int v) {
  const Mesh& mesh = c.mesh();
  for (const int u : mesh.neighbours(v))
    if (mesh.tag(mesh.find_edge(v, u)) != 0 && mesh.is_border_vertex(u)) return true;
  return false;
}

bool is_crowded(const Conforming& c, int v) {
  const Mesh& mesh = c.mesh();
  const double reach = c.merge(release_share);
  if (c.border.corner_distance(mesh.X[v]) < reach) return true;
  if (mesh.is_border_vertex(v)) return c.cloth().feature[v].kind == FeatureKind::Corner || hugs_border(c, v);
  const double room = c.border.distance(mesh.X[v]);
  if (room >= reach) return false;
  if (room < c.merge(last_share)) return true;  // should have been merged with the chain's end, which was not possible
  if (c.cloth().feature[v].kind == FeatureKind::Corner || !ends_at_border_beside(c, v)) return true;
  const Vec2 tangent = chain_tangent(c.cloth(), v, c.obstacles);
  return c.border.distance_along(mesh.X[v], tangent, c.border_cosine(release_angle_share)) < reach;
}

// At the border even chains that meet in a corner run into each other, when it is the corner that leaves over the
// border: it ends no chain there.
bool runs_into_chain(const Conforming& c, int v) {
  const Mesh& mesh = c.mesh();
  const FeatureId& feature = c.cloth().feature[v];
  if (feature.kind != FeatureKind::Edge) return false;
  const double reach = c.merge(cross_share);
  const auto comes_after = [&](int u) {
    const FeatureId& other = c.cloth().feature[u];
    return ends_beside(c, u, mesh.X[v], feature, reach) &&
           std::pair(other.obstacle, other.index) < std::pair(feature.obstacle, feature.index);
  };
  if (mesh.is_border_vertex(v)) {
    const std::vector<int> around = mesh.neighbours(v);
    if (comes_after(around.front()) || comes_after(around.back())) return true;
  }
  return passes_by(c, v, mesh.X[v], feature, reach);
}

// Of two that run into each other one is enough.
bool gives_way_to(const Conforming& c, int v, int u) {
  return c.cloth().feature[u].kind == FeatureKind::Corner || u < v;
}

// Distance of P from half-edge h in the material.
double distance(const Mesh& mesh, int h, const Vec2& P) {
  const Vec2 a = mesh.X[mesh.from(h)], e = mesh.X[mesh.to(h)] - a;
  const double t = std::clamp(e.dot(P - a) / e.squaredNorm(), 0.0, 1.0);
  return (a + t * e - P).norm();
}

int n_links(const Conforming& c, int v) {
  const std::vector<int> out = c.mesh().neighbours(v);
  return static_cast<int>(
      std::count_if(out.begin(), out.end(), [&](int u) { return c.mesh().tag(c.mesh().find_edge(v, u)) != 0; }));
}

// Two layers of cloth on one corner: the second lets go, or the one that is off the corner.
int second_on_corner(const Conforming& c, int v) {
  const Mesh& mesh = c.mesh();
  for (int q = v + 1; q < mesh.vertex_slots(); ++q)
    if (mesh.vertex_live(q) && c.cloth().feature[q] == c.cloth().feature[v] &&
        (mesh.X[q] - mesh.X[v]).norm() < c.merge(chain_merge_share))
      return c.cloth().rides(q) && !c.cloth().rides(v) ? v : q;
  return Mesh::none;
}

// Two ends of chains: of layers on one edge, where what is between them is drawn away, or of two edges beside a corner
// that nothing rides on. The one with fewer links lets go.
int second_end(const Conforming& c, int v) {
  const Mesh& mesh = c.mesh();
  for (const int u : mesh.neighbours(v)) {
    if (!c.cloth().rides(u) || mesh.tag(mesh.find_edge(v, u)) != 0) continue;
    if ((mesh.X[u] - mesh.X[v]).norm() >= c.merge(cross_share)) continue;
    const bool is_other = c.cloth().feature[u].kind == FeatureKind::Edge && n_links(c, u) < n_links(c, v);
    const int second = is_other ? u : v;
    if (n_links(c, second) < 2) return second;
  }
  return Mesh::none;
}

// Whether v has no links, and a chain of its own feature passes it by.
bool is_left_out(const Conforming& c, int v) {
  const Mesh& mesh = c.mesh();
  if (n_links(c, v) != 0) return false;
  const FeatureId& feature = c.cloth().feature[v];
  const int tag = edge_tag(feature.obstacle, feature.index);
  const std::vector<int> around = mesh.neighbours(v);
  return std::any_of(around.begin(), around.end(), [&](int u) {
    return !mesh.all_outgoing(
        u, [&](int h) { return mesh.tag(h) != tag || distance(mesh, h, mesh.X[v]) >= c.merge(last_share); });
  });
}

}  // namespace

bool drop_second_rider(Conforming& c, int v) {
  if (c.cloth().feature[v].kind == FeatureKind::Corner) {
    const int second = second_on_corner(c, v);
    if (second != Mesh::none) let_go(c, second);
    return second != Mesh::none;
  }
  if (!c.cloth().rides(v)) return false;
  const int second = is_left_out(c, v) ? v : second_end(c, v);
  if (second != Mesh::none) let_go(c, second);
  return second != Mesh::none;
}

bool is_parted(const Conforming& c, const FeatureId& feature, const Vec3& x, int u) {
  if (feature.kind != FeatureKind::Edge || !c.cloth().rides(u) || !lies_on(c.cloth().feature[u], feature, c.obstacles))
    return false;
  const WorldEdge edge = world_edge(feature, c.obstacles);
  const auto [from, to] = std::minmax({edge.parameter(x), edge.parameter(c.mesh().x[u])});
  return was_left_between(c.cloth(), feature, from, to, c.left_between());
}

bool ends_beside(const Conforming& c, int u, const Vec2& P, const FeatureId& feature, double reach) {
  const FeatureId& other = c.cloth().feature[u];
  return other.kind == FeatureKind::Edge && !(other == feature) && c.mesh().is_border_vertex(u) &&
         (c.mesh().X[u] - P).norm() < reach;
}

bool passes_by(const Conforming& c, int vertex, const Vec2& P, const FeatureId& feature, double reach) {
  const Mesh& mesh = c.mesh();
  for (const int out : mesh.outgoing(vertex)) {
    for (const int h : {out, Mesh::next(out), Mesh::prev(out)}) {
      const FeatureId& end = c.cloth().feature[mesh.from(h)];
      if (end.kind == FeatureKind::Edge && gives_way(feature, end, c.obstacles) &&
          (mesh.X[mesh.from(h)] - P).norm() < reach)
        return true;
      if (mesh.tag(h) == 0 || !gives_way(feature, tag_feature(mesh.tag(h)), c.obstacles)) continue;
      if (distance(mesh, h, P) < reach) return true;
    }
  }
  return false;
}

// A fold that has lifted off is led by nothing, and gives way to whatever else rides beside it. So does what a chain
// has left standing: it stays in its place in the material, and a rider that is not linked to it, so that the two
// cannot be merged, would run into it.
bool drifts_into_rider(const Conforming& c, int v) {
  const Mesh& mesh = c.mesh();
  const FeatureId& feature = c.cloth().feature[v];
  if (!feature.lifted && c.cloth().left.empty()) return false;  // nothing stands, nothing is parted
  const std::vector<int> around = mesh.neighbours(v);
  return std::any_of(around.begin(), around.end(), [&](int u) {
    if (!c.cloth().rides(u) || mesh.tag(mesh.find_edge(v, u)) != 0) return false;
    const bool stands = feature.away > 0 || (gives_way_to(c, v, u) && is_parted(c, feature, mesh.x[v], u));
    if (!feature.lifted && !stands) return false;
    // Two that travel together do not come nearer.
    const double speed = (c.cloth().V[u] - c.cloth().V[v]).norm();
    const double ahead = stands ? need_share * c.options.look_ahead * speed : 0.0;
    return (mesh.X[u] - mesh.X[v]).norm() < std::max(c.merge(cross_share), ahead);
  });
}

// A method without Eulerian unknowns makes its chains anew in every step.
void let_go(Conforming& c, int v) {
  if (c.options.eulerian && exists(c.cloth().feature[v], c.obstacles))
    c.editor.note_left(stretches_at(c.cloth(), v, c.obstacles));
  c.editor.release(v);
}

// All are judged before any is released: a release clears the tags that the others' tangents come from.
void release_strays(Conforming& c) {
  std::vector<int> strays;
  for (int v = 0; v < c.mesh().vertex_slots(); ++v)
    if (c.cloth().is_eol(v) && (has_left(c, v) || is_crowded(c, v) || runs_into_chain(c, v) || drifts_into_rider(c, v)))
      strays.push_back(v);
  for (const int v : strays) let_go(c, v);
}

}  // namespace crease
