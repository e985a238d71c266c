// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "crease/base/require.hpp"
#include "crease/geometry/mesh.hpp"
#include "crease/geometry/triangle.hpp"

namespace crease {
namespace {

/// Smallest ratio of altitude to longest edge of a new face [-]. Rounding leaves 1e-16 / edge length (about 1e-13) of
/// it between three points of a straight border; anything a simulation can use is above 1e-3.
constexpr double shape_floor = 1e-9;

bool is_sound(const Vec2& a, const Vec2& b, const Vec2& c, double min_area = 0.0) {
  const double doubled_area = orient2d(a, b, c);
  const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return doubled_area > 0 && doubled_area > shape_floor * longest && doubled_area > 2 * min_area;
}

bool contains(const std::array<int, 3>& face, int v) {
  return face[0] == v || face[1] == v || face[2] == v;
}

}  // namespace

// -- bookkeeping shared by the operations ----------------------------------------------------------------------------

int Mesh::add_face(int a, int b, int c) {
  faces_.push_back({a, b, c});
  twin_.resize(3 * faces_.size(), none);
  tag_.resize(3 * faces_.size(), 0);
  ++n_faces_;
  return face_slots() - 1;
}

int Mesh::add_vertex(const Vec2& material, const Vec3& world) {
  X.push_back(material);
  x.push_back(world);
  vertex_halfedge_.push_back(none);
  if (has_seams()) tied_.push_back(vertex_slots() - 1);
  ++n_vertices_;
  return vertex_slots() - 1;
}

void Mesh::remove_face(int f) {
  for (int k = 0; k < 3; ++k) {
    faces_[f][k] = twin_[3 * f + k] = none;
    tag_[3 * f + k] = 0;
  }
  --n_faces_;
}

void Mesh::link(int h, int g) {
  twin_[h] = g;
  if (g != none) twin_[g] = h;
}

void Mesh::move_side(int from_h, int to_h) {
  link(to_h, twin_[from_h]);
  tag_[to_h] = tag_[from_h];
  twin_[from_h] = none;
  tag_[from_h] = 0;
}

void Mesh::anchor(int h) {
  const int start = h;
  while (twin_[h] != none) {
    h = next(twin_[h]);
    if (h == start) break;
  }
  vertex_halfedge_[from(start)] = h;
}

// -- split -----------------------------------------------------------------------------------------------------------

bool Mesh::can_split(int h, double t) const {
  const int other = seam_twin(h);
  return can_split_side(h, t) && (other == none || can_split_side(other, 1 - t));
}

// No triangle has both sides of a seam, so the first split leaves the second as it was.
Mesh::Split Mesh::split(int h, double t) {
  CREASE_ASSERT(can_split(h, t));
  const int other = seam_twin(h);
  Split result = split_side(h, t);
  if (other == none) return result;
  const Split there = split_side(other, 1 - t);
  result.tied = there.vertex;
  result.faces.insert(result.faces.end(), there.faces.begin(), there.faces.end());
  x[there.vertex] = x[result.vertex];
  tie(result.vertex, there.vertex);
  return result;
}

bool Mesh::can_split_side(int h, double t) const {
  if (!(t > 0 && t < 1)) return false;
  const Vec2 m = X[from(h)] + t * (X[to(h)] - X[from(h)]);
  for (const int side : {h, twin_[h]}) {
    if (side == none) continue;
    const Vec2 &a = X[from(side)], &b = X[to(side)], &c = X[opposite(side)];
    if (!is_sound(a, m, c) || !is_sound(m, b, c)) return false;
  }
  return true;
}

// Before:  a --h--> b with c on the left and, unless h is on the border, d on the right.
// After:   face of h = (a, m, c), new face (m, b, c); face of the twin g = (m, a, d), new face (b, m, d).
// h and g keep their slots as a -> m and m -> a.
Mesh::Split Mesh::split_side(int h, double t) {
  const int g = twin_[h], a = from(h), b = to(h), c = opposite(h), tag = tag_[h];
  const int m = add_vertex(X[a] + t * (X[b] - X[a]), x[a] + t * (x[b] - x[a]));
  const int f = face_of(h), f_new = add_face(m, b, c);
  faces_[f][(h + 1) % 3] = m;
  move_side(next(h), 3 * f_new + 1);
  link(next(h), 3 * f_new + 2);
  tag_[3 * f_new] = tag;
  Split result{m, {f, f_new}};
  if (g != none) {
    const int d = opposite(g), f2 = face_of(g), f2_new = add_face(b, m, d);
    faces_[f2][g % 3] = m;
    move_side(prev(g), 3 * f2_new + 2);
    link(prev(g), 3 * f2_new + 1);
    link(3 * f_new, 3 * f2_new);
    tag_[3 * f2_new] = tag;
    result.faces.insert(result.faces.end(), {f2, f2_new});
    anchor(3 * f2_new + 2);
  }
  anchor(3 * f_new);
  anchor(3 * f_new + 1);
  return result;
}

bool Mesh::can_split_face(int f, const Vec3& b) const {
  if (!(b.minCoeff() > 0)) return false;
  const auto X_f = material_corners(*this, f);
  const Vec2 p = (b[0] * X_f[0] + b[1] * X_f[1] + b[2] * X_f[2]) / b.sum();
  return is_sound(X_f[0], X_f[1], p) && is_sound(X_f[1], X_f[2], p) && is_sound(X_f[2], X_f[0], p);
}

Mesh::Split Mesh::split_face(int f, const Vec3& b) {
  CREASE_ASSERT(can_split_face(f, b));
  const auto [i, j, k] = faces_[f];
  const Vec3 w = b / b.sum();
  const int p = add_vertex(w[0] * X[i] + w[1] * X[j] + w[2] * X[k], w[0] * x[i] + w[1] * x[j] + w[2] * x[k]);
  const int f1 = add_face(j, k, p), f2 = add_face(k, i, p);
  faces_[f][2] = p;
  move_side(3 * f + 1, 3 * f1);
  move_side(3 * f + 2, 3 * f2);
  link(3 * f + 1, 3 * f1 + 2);
  link(3 * f1 + 1, 3 * f2 + 2);
  link(3 * f2 + 1, 3 * f + 2);
  for (const int h : {3 * f1, 3 * f2, 3 * f + 2}) anchor(h);
  return {p, {f, f1, f2}};
}

// -- flip ------------------------------------------------------------------------------------------------------------

bool Mesh::can_flip(int h) const {
  const int g = twin_[h];
  if (g == none || tag_[h] != 0) return false;
  const int a = from(h), b = opposite(h), c = to(h), d = opposite(g);
  return find_edge(b, d) == none && !are_tied(b, d) && is_sound(X[d], X[b], X[a]) && is_sound(X[b], X[d], X[c]);
}

// Before:  h = a -> c in face (a, c, b), g = c -> a in face (c, a, d).
// After:   h = d -> b in face (d, b, a), g = b -> d in face (b, d, c).
std::array<int, 2> Mesh::flip(int h) {
  CREASE_ASSERT(can_flip(h));
  const int g = twin_[h];
  const int a = from(h), b = opposite(h), c = to(h), d = opposite(g);
  const int cb = twin_[next(h)], cb_tag = tag_[next(h)], ba = twin_[prev(h)], ba_tag = tag_[prev(h)];
  const int ad = twin_[next(g)], ad_tag = tag_[next(g)], dc = twin_[prev(g)], dc_tag = tag_[prev(g)];
  const auto place = [this](int side, int v0, int v1, int v2) {
    faces_[face_of(side)][side % 3] = v0;
    faces_[face_of(side)][next(side) % 3] = v1;
    faces_[face_of(side)][prev(side) % 3] = v2;
  };
  place(h, d, b, a);
  place(g, b, d, c);
  const auto attach = [this](int side, int twin, int tag) {
    link(side, twin);
    tag_[side] = tag;
  };
  attach(next(h), ba, ba_tag);
  attach(prev(h), ad, ad_tag);
  attach(next(g), dc, dc_tag);
  attach(prev(g), cb, cb_tag);
  for (const int side : {next(h), prev(h), next(g), prev(g)}) anchor(side);
  return {face_of(h), face_of(g)};
}

// -- collapse --------------------------------------------------------------------------------------------------------

bool Mesh::can_collapse(int h, double min_area) const {
  return can_collapse_vertex(from(h), to(h), min_area);
}

Mesh::Collapse Mesh::collapse(int h) {
  return collapse_vertex(from(h), to(h));
}

// The two sides of a seam share no face, nor would they share an edge: what one collapse does leaves the other as it
// is.
bool Mesh::can_collapse_vertex(int vertex, int into, double min_area) const {
  if (!can_collapse_side(vertex, into, min_area)) return false;
  if (!on_seam(vertex)) return !closes_a_seam(vertex, into);
  if (!seam_allows_collapse(vertex, into)) return false;
  const Ends there = across_seam(vertex, into);
  return can_collapse_side(there.vertex, there.into, min_area);
}

bool Mesh::can_collapse_side(int vertex, int into, double min_area) const {
  const int edge = find_edge(vertex, into);
  if (edge == none || !tags_allow_collapse(vertex, edge) || !links_allow_collapse(vertex, into, edge)) return false;
  return all_outgoing(vertex, [&](int h) {
    const int b = to(h), c = opposite(h);
    if (b == into || c == into) return true;
    return is_sound(X[into], X[b], X[c], min_area) && !are_tied(b, into) && !are_tied(c, into);
  });
}

/// Topology: the result is a manifold with the same border components, and no border vertex leaves the border.
bool Mesh::links_allow_collapse(int vertex, int into, int edge) const {
  if (is_border_vertex(vertex) && (!is_border(edge) || is_material_corner(vertex))) return false;
  // A lone triangle has nowhere to go.
  if (is_border(edge) && is_border(next(edge)) && is_border(prev(edge))) return false;
  // Link condition: the only vertices joined to both ends are those opposite to the edge.
  const int third = opposite(edge), fourth = is_border(edge) ? none : opposite(twin_[edge]);
  const auto is_no_shortcut = [&](int v) {
    return v == into || v == third || v == fourth || find_edge(v, into) == none;
  };
  return all_outgoing(
      vertex, [&](int h) { return is_no_shortcut(to(h)) && (!is_border(prev(h)) || is_no_shortcut(opposite(h))); });
}

bool Mesh::tags_allow_collapse(int vertex, int edge) const {
  const int along = tag_[edge];
  int n_tagged = 0;
  const auto fits = [&](int h) {
    n_tagged += tag_[h] != 0 ? 1 : 0;
    return tag_[h] == 0 || tag_[h] == along;
  };
  const bool all_fit = all_outgoing(vertex, [&](int h) { return fits(h) && (!is_border(prev(h)) || fits(prev(h))); });
  if (!all_fit || (n_tagged != 0 && n_tagged != 2)) return false;
  // Where two edges merge, two different lines must not.
  for (const int side : {edge, twin_[edge]}) {
    if (side == none) continue;
    const int p = tag_[next(side)], q = tag_[prev(side)];
    if (p != 0 && q != 0 && p != q) return false;
  }
  return true;
}

Mesh::Collapse Mesh::collapse_vertex(int vertex, int into) {
  CREASE_ASSERT(can_collapse_vertex(vertex, into));
  Collapse result{vertex, into, {}, {}, across_seam(vertex, into)};
  collapse_side(result, vertex, into);
  if (result.tied.vertex == none) return result;
  collapse_side(result, result.tied.vertex, result.tied.into);
  for (const int gone : {vertex, result.tied.vertex}) tied_[gone] = gone;
  return result;
}

void Mesh::collapse_side(Collapse& result, int vertex, int into) {
  const auto first_removed = static_cast<std::ptrdiff_t>(result.removed_faces.size());
  for (const int h : outgoing(vertex)) {
    const int f = face_of(h);
    if (contains(faces_[f], into)) {
      result.removed_faces.push_back(f);
    } else {
      faces_[f][h % 3] = into;
      result.faces.push_back(f);
    }
  }
  std::vector<int> anchors;
  for (auto removed = result.removed_faces.begin() + first_removed; removed != result.removed_faces.end(); ++removed) {
    const int f = *removed;
    // The face's side between the two ends vanishes; the other two become one edge.
    int k = 0;
    while (faces_[f][(k + 2) % 3] == vertex || faces_[f][(k + 2) % 3] == into) ++k;
    const int side = 3 * f + k;
    const int p = twin_[next(side)], q = twin_[prev(side)];
    const int tag = tag_[next(side)] != 0 ? tag_[next(side)] : tag_[prev(side)];
    for (const auto& [one, other] : {std::pair{p, q}, std::pair{q, p}}) {
      if (one == none) continue;
      twin_[one] = other;
      tag_[one] = tag;
      anchors.insert(anchors.end(), {one, next(one)});
    }
    remove_face(f);
  }
  vertex_halfedge_[vertex] = none;
  --n_vertices_;
  for (const int h : anchors) {
    if (face_live(face_of(h))) anchor(h);
  }
}

}  // namespace crease
