// SPDX-License-Identifier: MIT
#include "neighbourhood.hpp"

namespace crease {

std::vector<int> edges_at(const Mesh& mesh, std::span<const int> vertices) {
  std::vector<char> chosen(static_cast<std::size_t>(3 * mesh.face_slots()), 0);
  for (const int v : vertices) {
    if (!mesh.vertex_live(v)) continue;
    mesh.all_outgoing(v, [&](int h) {
      for (int k = 0; k < 3; ++k, h = Mesh::next(h)) chosen[mesh.edge_of(h)] = 1;
      return true;
    });
  }
  std::vector<int> edges;
  for (int h = 0; h < 3 * mesh.face_slots(); ++h)
    if (chosen[h]) edges.push_back(h);
  return edges;
}

std::vector<int> halfedges_around(const Mesh& mesh, int vertex) {
  std::vector<int> result;
  mesh.all_outgoing(vertex, [&](int h) {
    for (int k = 0; k < 3; ++k, h = Mesh::next(h)) result.push_back(h);
    return true;
  });
  return result;
}

std::vector<int> faces_around(const Mesh& mesh, int vertex) {
  std::vector<int> faces = mesh.outgoing(vertex);
  for (int& h : faces) h = Mesh::face_of(h);
  return faces;
}

}  // namespace crease
