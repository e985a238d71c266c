// SPDX-License-Identifier: MIT
#include "crease/geometry/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "crease/base/require.hpp"
#include "crease/geometry/triangle.hpp"

namespace crease {
namespace {

/// A directed edge and its half-edge; sorted, they answer "which half-edge runs from a to b".
struct DirectedEdge {
  int from, to, h;
  bool operator<(const DirectedEdge& o) const { return std::tie(from, to, h) < std::tie(o.from, o.to, o.h); }
};

/// Messages are made only once something is wrong: require() would build one a face.
[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument("Mesh: " + what);
}

[[noreturn]] void refuse_face(int f, const std::string& what) {
  refuse("face " + std::to_string(f) + " " + what);
}

}  // namespace

Mesh::Mesh(std::vector<Vec2> material, std::vector<Vec3> world, const std::vector<std::array<int, 3>>& faces)
    : X(std::move(material)), x(std::move(world)), faces_(faces) {
  if (X.size() != x.size()) {
    refuse("expected as many material as world positions, got " + std::to_string(X.size()) + " and " +
           std::to_string(x.size()));
  }
  constexpr auto limit = static_cast<std::size_t>(std::numeric_limits<int>::max() / 3);
  if (faces.size() >= limit || X.size() >= limit) refuse("more vertices or faces than an int can number");
  n_vertices_ = vertex_slots();
  n_faces_ = face_slots();
  for (int v = 0; v < n_vertices_; ++v) {
    if (!X[v].allFinite() || !x[v].allFinite()) refuse("vertex " + std::to_string(v) + " has a position not finite");
  }
  for (int f = 0; f < n_faces_; ++f) require_face(f);
  pair_halfedges();
  anchor_vertices();
}

void Mesh::require_face(int f) const {
  const auto& [a, b, c] = faces_[f];
  for (const int v : {a, b, c}) {
    if (v >= 0 && v < vertex_slots()) continue;
    refuse_face(f, "names vertex " + std::to_string(v) + " of " + std::to_string(vertex_slots()));
  }
  if (a == b || b == c || c == a) refuse_face(f, "names a vertex twice");
  const double area = material_area(f);
  if (area == 0) refuse_face(f, "has no area in material space");
  if (!(area > 0)) refuse_face(f, "is inverted in material space: expected counter-clockwise corners");
}

void Mesh::pair_halfedges() {
  std::vector<DirectedEdge> directed;
  directed.reserve(3 * faces_.size());
  for (int h = 0; h < 3 * face_slots(); ++h) directed.push_back({from(h), to(h), h});
  std::sort(directed.begin(), directed.end());

  int repeated = none;  // the first face that runs along an edge the way an earlier one does
  for (std::size_t i = 1; i < directed.size(); ++i) {
    const auto &p = directed[i - 1], &q = directed[i];
    if (p.from == q.from && p.to == q.to && (repeated == none || q.h / 3 < repeated)) repeated = q.h / 3;
  }
  if (repeated != none) {
    refuse_face(repeated, "makes an edge non-manifold: another face runs along it the same way");
  }
  twin_.assign(directed.size(), none);
  tag_.assign(directed.size(), 0);
  for (const DirectedEdge& e : directed) {
    const auto found = std::lower_bound(directed.begin(), directed.end(), DirectedEdge{e.to, e.from, none});
    if (found != directed.end() && found->from == e.to && found->to == e.from) twin_[e.h] = found->h;
  }
}

void Mesh::anchor_vertices() {
  vertex_halfedge_.assign(X.size(), none);
  std::vector<int> n_incident(X.size(), 0);
  for (int h = 0; h < 3 * face_slots(); ++h) {
    ++n_incident[from(h)];
    if (vertex_halfedge_[from(h)] == none) anchor(h);
  }
  std::vector<bool> one_fan(X.size(), false), once(X.size(), false);
  for (int v = 0; v < n_vertices_; ++v) {
    if (n_incident[v] == 0) refuse("vertex " + std::to_string(v) + " is in no face");
    one_fan[v] = static_cast<int>(outgoing(v).size()) == n_incident[v];
    once[v] = winds_once(v);
  }
  for (int f = 0; f < n_faces_; ++f) {
    for (const int v : faces_[f]) {
      const std::string name = one_fan[v] && once[v] ? "" : std::to_string(v);
      if (!one_fan[v]) refuse_face(f, "makes vertex " + name + " non-manifold: its faces form more than one fan");
      if (!once[v])
        refuse_face(f, "is one of those that go round vertex " + name + " more than once in material space");
    }
  }
}

bool Mesh::winds_once(int v) const {
  if (is_border_vertex(v)) return true;
  // One turn enters the upper half plane once, and each step turns by less than half a turn.
  const auto around = neighbours(v);
  int entered = 0;
  bool below = X[around.back()].y() < X[v].y();
  for (const int i : around) {
    const bool now_below = X[i].y() < X[v].y();
    entered += below && !now_below ? 1 : 0;
    below = now_below;
  }
  return entered == 1;
}

bool Mesh::is_border_vertex(int v) const {
  return twin_[vertex_halfedge_[v]] == none;
}

std::vector<int> Mesh::outgoing(int v) const {
  std::vector<int> result;
  result.reserve(8);
  all_outgoing(v, [&](int h) {
    result.push_back(h);
    return true;
  });
  return result;
}

std::vector<int> Mesh::neighbours(int v) const {
  std::vector<int> result;
  result.reserve(8);
  const int first = vertex_halfedge_[v];
  int h = first;
  while (true) {
    result.push_back(to(h));
    const int across = twin_[prev(h)];
    if (across == none) result.push_back(opposite(h));
    if (across == none || across == first) return result;
    h = across;
  }
}

int Mesh::find_edge(int a, int b) const {
  if (!vertex_live(a)) return none;
  int found = none;
  all_outgoing(a, [&](int h) {
    if (to(h) == b) found = h;
    if (opposite(h) == b && is_border(prev(h))) found = prev(h);
    return found == none;
  });
  return found;
}

std::vector<int> Mesh::edges() const {
  std::vector<int> result;
  result.reserve(static_cast<std::size_t>(n_vertices_ + n_faces_));
  for (int h = 0; h < 3 * face_slots(); ++h) {
    if (face_live(h / 3) && edge_of(h) == h) result.push_back(h);
  }
  return result;
}

double Mesh::material_area(int f) const {
  const auto& [a, b, c] = faces_[f];
  return 0.5 * orient2d(X[a], X[b], X[c]);
}

double Mesh::material_length(int h) const {
  return (X[to(h)] - X[from(h)]).norm();
}

double Mesh::border_turn(int v) const {
  CREASE_ASSERT(is_border_vertex(v));
  const auto around = neighbours(v);
  const Vec2 in = X[v] - X[around.back()], out = X[around.front()] - X[v];
  return std::atan2(std::abs(in.x() * out.y() - in.y() * out.x()), in.dot(out));
}

bool Mesh::is_material_corner(int v, double angle) const {
  return is_border_vertex(v) && border_turn(v) > angle;
}

void Mesh::set_tag(int h, int tag) {
  tag_[h] = tag;
  if (twin_[h] != none) tag_[twin_[h]] = tag;
}

Mesh::Renumbering Mesh::compact() {
  Renumbering ids;
  ids.vertex.assign(X.size(), none);
  ids.face.assign(faces_.size(), none);
  int n = 0;
  for (int v = 0; v < vertex_slots(); ++v) {
    if (vertex_live(v)) ids.vertex[v] = n++;
  }
  n = 0;
  for (int f = 0; f < face_slots(); ++f) {
    if (face_live(f)) ids.face[f] = n++;
  }
  const auto halfedge_id = [&](int h) { return h == none ? none : 3 * ids.face[h / 3] + h % 3; };
  // Ids never grow, so every slot is read before it is written over.
  for (int v = 0; v < vertex_slots(); ++v) {
    const int to_slot = ids.vertex[v];
    if (to_slot == none) continue;
    X[to_slot] = X[v];
    x[to_slot] = x[v];
    vertex_halfedge_[to_slot] = halfedge_id(vertex_halfedge_[v]);
    if (has_seams()) tied_[to_slot] = ids.vertex[tied_[v]];
  }
  for (int f = 0; f < face_slots(); ++f) {
    const int to_slot = ids.face[f];
    if (to_slot == none) continue;
    for (int k = 0; k < 3; ++k) {
      faces_[to_slot][k] = ids.vertex[faces_[f][k]];
      twin_[3 * to_slot + k] = halfedge_id(twin_[3 * f + k]);
      tag_[3 * to_slot + k] = tag_[3 * f + k];
    }
  }
  X.resize(n_vertices_);
  x.resize(n_vertices_);
  vertex_halfedge_.resize(n_vertices_);
  if (has_seams()) tied_.resize(n_vertices_);
  faces_.resize(n_faces_);
  twin_.resize(3 * static_cast<std::size_t>(n_faces_));
  tag_.resize(3 * static_cast<std::size_t>(n_faces_));
  return ids;
}

}  // namespace crease
