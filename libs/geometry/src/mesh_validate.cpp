// SPDX-License-Identifier: MIT
#include <algorithm>

#include "crease/geometry/mesh.hpp"

namespace crease {

std::optional<std::string> Mesh::face_trouble(int f) const {
  const std::string name = "face " + std::to_string(f);
  for (const int v : faces_[f]) {
    if (v < 0 || v >= vertex_slots() || !vertex_live(v)) return name + " names a vertex that does not live";
  }
  for (int k = 0; k < 3; ++k) {
    const int h = 3 * f + k, g = twin_[h];
    const std::string side = "half-edge " + std::to_string(h);
    if (from(h) == to(h)) return name + " names a vertex twice";
    if (g == none) continue;
    if (g < 0 || g >= 3 * face_slots() || !face_live(g / 3)) return side + " has a twin that does not live";
    if (twin_[g] != h || from(g) != to(h) || to(g) != from(h)) return side + " and its twin disagree";
    if (tag_[g] != tag_[h]) return side + " and its twin carry different tags";
  }
  if (!(material_area(f) > 0)) return name + " has no positive material area";
  return std::nullopt;
}

std::optional<std::string> Mesh::vertex_trouble(int v, int n_incident) const {
  const std::string name = "vertex " + std::to_string(v);
  if (!vertex_live(v)) return n_incident == 0 ? std::nullopt : std::optional(name + " does not live but has faces");
  if (!X[v].allFinite() || !x[v].allFinite()) return name + " has a position that is not finite";
  const int first = vertex_halfedge_[v];
  if (first < 0 || first >= 3 * face_slots() || !face_live(first / 3) || from(first) != v) {
    return name + " is anchored to a half-edge that does not leave it";
  }
  std::vector<int> seen;
  bool open = false;
  for (int h = first; static_cast<int>(seen.size()) <= n_incident;) {
    seen.push_back(to(h));
    const int across = twin_[prev(h)];
    open = across == none;
    if (open) seen.push_back(opposite(h));
    if (open || across == first) break;
    h = across;
  }
  if (static_cast<int>(seen.size()) != n_incident + (open ? 1 : 0)) return name + " has more than one fan of faces";
  if (open != (twin_[first] == none)) return name + " on the border is not anchored to its first half-edge";
  std::sort(seen.begin(), seen.end());
  if (std::adjacent_find(seen.begin(), seen.end()) != seen.end()) return name + " meets a neighbour twice";
  if (!winds_once(v)) return name + " has faces that go round it more than once";
  return std::nullopt;
}

std::optional<std::string> Mesh::validate() const {
  const auto n_halfedges = 3 * faces_.size();
  if (x.size() != X.size() || vertex_halfedge_.size() != X.size()) return "vertex arrays differ in length";
  if (twin_.size() != n_halfedges || tag_.size() != n_halfedges) return "half-edge arrays differ in length";
  std::vector<int> n_incident(X.size(), 0);
  int live_faces = 0, live_vertices = 0;
  for (int f = 0; f < face_slots(); ++f) {
    if (!face_live(f)) continue;
    if (auto trouble = face_trouble(f)) return trouble;
    for (const int v : faces_[f]) ++n_incident[v];
    ++live_faces;
  }
  for (int v = 0; v < vertex_slots(); ++v) {
    if (auto trouble = vertex_trouble(v, n_incident[v])) return trouble;
    live_vertices += vertex_live(v) ? 1 : 0;
  }
  if (live_faces != n_faces_) return "the number of live faces is not n_faces()";
  if (live_vertices != n_vertices_) return "the number of live vertices is not n_vertices()";
  return seam_trouble();
}

}  // namespace crease
