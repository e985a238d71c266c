// SPDX-License-Identifier: MIT
#include <numeric>
#include <utility>

#include "crease/base/require.hpp"
#include "crease/geometry/mesh.hpp"

namespace crease {

bool Mesh::are_tied(int a, int b) const {
  int v = a;
  while (v != b) {
    v = tied(v);
    if (v == a) return false;
  }
  return true;
}

// One half-edge leaves each vertex along the border: its anchor.
int Mesh::seam_twin(int h) const {
  if (!has_seams() || !is_border(h)) return none;
  const int a = from(h), b = to(h);
  int v = b;
  do {
    const int out = vertex_halfedge_[v];
    if (is_border(out) && are_tied(to(out), a)) return out;
    v = tied(v);
  } while (v != b);
  return none;
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

// Whether another border edge runs the same way between the same places: no surface has three sides at one edge.
bool Mesh::has_double(int h) const {
  for (int v = tied(from(h)); v != from(h); v = tied(v)) {
    const int out = vertex_halfedge_[v];
    if (is_border(out) && are_tied(to(out), to(h))) return true;
  }
  return false;
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
      if (is_border(h) && has_double(h))
        return "half-edge " + std::to_string(h) + " runs beside one that is sewn to it";
  }
  return std::nullopt;
}

}  // namespace crease
