// SPDX-License-Identifier: MIT
#include <cmath>
#include <numeric>
#include <utility>

#include "crease/base/require.hpp"
#include "crease/geometry/mesh.hpp"

namespace crease {

namespace {

// A seam that bends by less [rad], and divisions of its two sides that differ by less, are straight and the same:
// splits leave 1e-16 of |X| over the edge's length behind, about 1e-13.
constexpr double seam_tolerance = 1e-9;

}  // namespace

bool Mesh::are_tied(int a, int b) const {
  int v = a;
  while (v != b) {
    v = tied(v);
    if (v == a) return false;
  }
  return true;
}

// One half-edge leaves each vertex along the border: its anchor.
int Mesh::border_halfedge(int a, int b, int except) const {
  int v = a;
  do {
    const int out = vertex_halfedge_[v];
    if (out != except && is_border(out) && are_tied(to(out), b)) return out;
    v = tied(v);
  } while (v != a);
  return none;
}

int Mesh::seam_twin(int h) const {
  return has_seams() && is_border(h) ? border_halfedge(to(h), from(h)) : none;
}

Mesh::Ends Mesh::across_seam(int vertex, int into) const {
  if (!has_seams()) return {};
  const int h = find_edge(vertex, into), g = h == none ? none : seam_twin(h);
  if (g == none) return {};
  return from(h) == vertex ? Ends{to(g), from(g)} : Ends{from(g), to(g)};
}

// At the end of a seam one vertex belongs to both sides.
bool Mesh::on_seam(int v) const {
  return has_seams() && (is_tied(v) || seam_twin(vertex_halfedge_[v]) != none);
}

void Mesh::tie(int a, int b) {
  require(vertex_live(a) && vertex_live(b) && x[a] == x[b], "Mesh::tie: expected live vertices at one place");
  if (!has_seams()) {
    tied_.resize(X.size());
    std::iota(tied_.begin(), tied_.end(), 0);
  }
  // Two rings that swap their next ones become one; within one ring that would cut it in two.
  if (!are_tied(a, b)) std::swap(tied_[a], tied_[b]);
}

bool Mesh::are_joined(int a, int b) const {
  return border_halfedge(a, b) != none || border_halfedge(b, a) != none;
}

// Whether the border edge that a collapse along the border leaves would run between the same two places as another one,
// which is what a seam is: so it goes at the open end of a tube, with the third vertex from last.
bool Mesh::closes_a_seam(int vertex, int into) const {
  if (!has_seams() || !is_border_vertex(vertex)) return false;
  const std::vector<int> around = neighbours(vertex);  // from the next one on the border to the one before
  const int after = around.front(), before = around.back();
  return (into == after || into == before) && are_joined(after, before);
}

// Whether a seam is the same without `vertex` and the one tied to it, which go along it.
bool Mesh::seam_allows_collapse(int vertex, int into) const {
  const std::vector<int> around = neighbours(vertex);
  if (into != around.front() && into != around.back()) return false;
  const int back = into == around.front() ? around.back() : around.front();
  const Ends there = across_seam(vertex, into), behind = across_seam(vertex, back);
  const int other = there.vertex;
  // An end that both sides share stays, and so does the last vertex before it, unless it goes the other way.
  if (other == none || other != behind.vertex || other == vertex || there.into == into) return false;
  if (tied(vertex) != other || tied(other) != vertex || are_joined(into, back)) return false;
  if (border_turn(vertex) > seam_tolerance || border_turn(other) > seam_tolerance) return false;
  const double ahead = (X[into] - X[vertex]).norm(), rest = (X[back] - X[vertex]).norm();
  const double ahead_there = (X[there.into] - X[other]).norm(), rest_there = (X[behind.into] - X[other]).norm();
  return std::abs(ahead * rest_there - rest * ahead_there) <=
         seam_tolerance * (ahead + rest) * (ahead_there + rest_there);
}

std::optional<std::string> Mesh::seam_trouble() const {
  if (!has_seams()) return std::nullopt;
  if (tied_.size() != X.size()) return "vertex arrays differ in length";
  std::vector<char> named(tied_.size(), 0);
  for (int v = 0; v < vertex_slots(); ++v) {
    const std::string name = "vertex " + std::to_string(v);
    const int u = tied_[v];
    if (u < 0 || u >= vertex_slots() || named[u]++ != 0) return name + " is tied to what another one is tied to";
    if (u == v) continue;
    if (!vertex_live(v) || !vertex_live(u)) return name + " or what it is tied to does not live";
    if (x[u] != x[v]) return name + " and what it is tied to stand apart";
  }
  for (int f = 0; f < face_slots(); ++f) {
    if (!face_live(f)) continue;
    const auto& [a, b, c] = faces_[f];
    if (are_tied(a, b) || are_tied(b, c) || are_tied(c, a)) return "face " + std::to_string(f) + " has tied corners";
    for (int h = 3 * f; h < 3 * f + 3; ++h)
      if (is_border(h) && border_halfedge(from(h), to(h), h) != none)  // no surface has three sides at one edge
        return "half-edge " + std::to_string(h) + " runs beside one that is sewn to it";
  }
  return std::nullopt;
}

}  // namespace crease
