// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "crease/geometry/mesh.hpp"

// What an operation may have changed, to be looked at again.
namespace crease {

/// Canonical half-edges of all faces at those of the vertices that live, ascending.
std::vector<int> edges_at(const Mesh& mesh, std::span<const int> vertices);
/// Half-edges of the faces at a vertex, face by face.
std::vector<int> halfedges_around(const Mesh& mesh, int vertex);
std::vector<int> faces_around(const Mesh& mesh, int vertex);

}  // namespace crease
