// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "support/meshes.hpp"

/// Independent answers to "what must the mesh look like after an operation": the face list, built from scratch.
namespace crease::support {

/// Meshes with ragged borders and holes of one triangle, where the link condition has work to do.
inline std::vector<NamedMesh> ragged_meshes() {
  auto result = all_meshes();
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Mesh mesh = grid(seed % 2 == 0 ? GridPattern::Right : GridPattern::Irregular, 6, 6, seed);
    Rng rng(seed);
    for (int n = 0; n < 12; ++n) {
      const auto P = material_corners(mesh, pick(rng, mesh.n_faces()));
      const Vec2 gone = (P[0] + P[1] + P[2]) / 3;
      try {
        mesh = cut(mesh, [&](const Vec2& c) { return c != gone; });
      } catch (const std::invalid_argument&) {
        // That face was the bridge between two fans of a vertex: keep it.
      }
    }
    result.push_back({"ragged " + std::to_string(seed), mesh});
  }
  return result;
}

/// The mesh of a face list, by construction from scratch, if there is one that uses every vertex but `without` and has
/// no sliver of round-off (altitude below 1e-9 of the longest edge).
inline std::optional<Mesh> rebuild(const Mesh& mesh, const std::vector<std::array<int, 3>>& faces,
                                   int without = Mesh::none) {
  std::vector<int> id;
  std::vector<Vec2> X;
  std::vector<Vec3> x;
  for (int v = 0; v < mesh.vertex_slots(); ++v) {
    id.push_back(static_cast<int>(X.size()));
    if (v == without || !mesh.vertex_live(v)) continue;
    X.push_back(mesh.X[v]);
    x.push_back(mesh.x[v]);
  }
  auto renamed = faces;
  for (auto& face : renamed) {
    for (int& v : face) v = id[v];
  }
  try {
    const Mesh built(X, x, renamed);
    for (int f = 0; f < built.n_faces(); ++f) {
      const auto P = material_corners(built, f);
      const double longest = std::max({(P[1] - P[0]).norm(), (P[2] - P[1]).norm(), (P[0] - P[2]).norm()});
      if (smallest_altitude(P) <= 1e-9 * longest) return std::nullopt;
    }
    return built;
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

inline std::vector<std::array<int, 3>> live_faces(const Mesh& mesh) {
  std::vector<std::array<int, 3>> faces;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (mesh.face_live(f)) faces.push_back(mesh.face(f));
  }
  return faces;
}

/// Faces with the smallest corner first, sorted: equal for equal meshes.
inline std::vector<std::array<int, 3>> canonical(std::vector<std::array<int, 3>> faces) {
  for (auto& f : faces) std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
  std::sort(faces.begin(), faces.end());
  return faces;
}

}  // namespace crease::support
